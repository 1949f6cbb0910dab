#!/usr/bin/env python3
"""Writes the scenes of examples/scenes. Deterministic: run again, it writes the same files.

The generator is written out below, so that no library's version changes the scenes.
"""
import json
import math
import pathlib

SCENES = pathlib.Path(__file__).resolve().parent / "scenes"


class Random:
    """The 64-bit linear congruential generator of Knuth's MMIX; the upper bits are used."""

    def __init__(self, seed):
        self.state = seed
        for _ in range(8):  # neighbouring seeds begin with similar numbers
            self.uniform(0, 1)

    def uniform(self, low, high):
        self.state = (6364136223846793005 * self.state + 1442695040888963407) % 2**64
        return low + (high - low) * (self.state >> 11) / 2**53


def sphere(center, radius, name=None):
    entry = {"sphere": {"center": [round(c, 6) for c in center], "radius": round(radius, 6)}}
    if name:
        entry["name"] = name
    return entry


def plane(point, normal, name=None):
    entry = {"plane": {"point": point, "normal": normal}}
    if name:
        entry["name"] = name
    return entry


def cylinder(point, axis, radius, name=None):
    entry = {"cylinder": {"point": [round(c, 6) for c in point], "axis": [round(c, 6) for c in axis], "radius": round(radius, 6)}}
    if name:
        entry["name"] = name
    return entry


def scene(objects, low, high):
    return {
        "vcell": 1,
        "base": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}},
        "objects": objects,
        "box": {"min": low, "max": high},
    }


def write(name, content):
    """One object a line."""
    lines = ["{"]
    lines.append(f'  "vcell": {content["vcell"]},')
    lines.append(f'  "base": {json.dumps(content["base"])},')
    lines.append('  "objects": [')
    lines.append(",\n".join("    " + json.dumps(o) for o in content["objects"]))
    lines.append("  ],")
    lines.append(f'  "box": {json.dumps(content["box"])}')
    lines.append("}")
    (SCENES / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def loose_spheres(count, seed, side, heights, radii, gap):
    """Spheres at random over the square [0, side]^2, no two of one radius, all `gap` apart at least from
    each other, from the base plane and from the square's sides."""
    random = Random(seed)
    placed = []
    while len(placed) < count:
        # The radius grows with every sphere placed: all are different.
        radius = radii[0] + (radii[1] - radii[0]) * (len(placed) * 0.618033988749895 % 1)
        center = [random.uniform(0, side), random.uniform(0, side), random.uniform(*heights)]
        inside = all(radius + gap <= c <= side - radius - gap for c in center[:2]) and center[2] >= radius + gap
        clear = all(math.dist(center, c) >= radius + r + gap for c, r in placed)
        if inside and clear:
            placed.append((center, radius))
    return placed


def distance_of_axes(p, a, q, b):
    """Between the lines p + s a and q + t b, axes of unit length."""
    normal = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    length = math.hypot(*normal)
    between = [y - x for x, y in zip(p, q)]
    if length < 1e-6:
        along = sum(x * y for x, y in zip(between, a))
        return math.sqrt(max(0, sum(x * x for x in between) - along * along))
    return abs(sum(x * y for x, y in zip(between, normal))) / length


def distance_to_axis(c, p, a):
    between = [y - x for x, y in zip(p, c)]
    along = sum(x * y for x, y in zip(between, a))
    return math.sqrt(max(0, sum(x * x for x in between) - along * along))


def pile(count, seed, side, heights):
    """Balls, and rods a fifth of them, over the square [0, side]^2, `gap` apart at least from each other and from
    the base plane. The rods lie in layers, along and across in turn, none quite parallel to another or to
    the base."""
    random, gap, layers = Random(seed), 0.01, 4
    balls, rods = [], []
    while len(rods) < count // 5:
        layer = len(rods) % layers
        radius = random.uniform(0.03, 0.12)
        place = random.uniform(0, side)
        turn, lean = random.uniform(-1, 1) / side, random.uniform(-0.2, 0.2) / side
        height = heights[0] + (heights[1] - heights[0]) * (layer + random.uniform(0.4, 0.6)) / layers
        axis = [1, turn, lean] if layer % 2 == 0 else [turn, 1, lean]
        point = [side / 2, place, height] if layer % 2 == 0 else [place, side / 2, height]
        length = math.hypot(*axis)
        axis = [x / length for x in axis]
        if all(distance_of_axes(point, axis, q, b) > radius + r + gap for q, b, r in rods):
            rods.append((point, axis, radius))
    while len(balls) < count - count // 5:
        radius = random.uniform(0.1, 0.5)
        center = [random.uniform(0, side), random.uniform(0, side), random.uniform(radius + gap, heights[1])]
        if (all(math.dist(center, c) > radius + r + gap for c, r in balls)
                and all(distance_to_axis(center, p, a) > radius + r + gap for p, a, r in rods)):
            balls.append((center, radius))
    return [sphere(c, r) for c, r in balls] + [cylinder(p, a, r) for p, a, r in rods]


def main():
    SCENES.mkdir(exist_ok=True)

    write("figure1.json", scene(
        [sphere((-0.45, -0.3, 0.75), 0.3, "O1"),
         sphere((0.5, -0.35, 0.6), 0.2, "O2"),
         sphere((0.05, 0.5, 0.9), 0.4, "O3")],
        [-1, -1, 0], [1, 1, 2]))

    write("figure2.json", scene(
        [sphere((-0.6, -0.5, 0.55), 0.25, "O1"),
         sphere((0.3, -0.6, 0.8), 0.35, "O2"),
         sphere((0.75, 0.2, 0.5), 0.15, "O3"),
         sphere((0.05, 0.1, 0.35), 0.1, "O4"),
         sphere((-0.7, 0.35, 0.9), 0.3, "O5"),
         sphere((0.1, 0.75, 0.65), 0.22, "O6")],
        [-1, -1, 0], [1, 1, 2]))

    # Fig. 12 and the last row of Table 3; each smaller row is the beginning of it.
    spheres = [sphere(c, r, f"O{i + 1}")
               for i, (c, r) in enumerate(loose_spheres(24, 12, 10, (1.0, 2.6), (0.25, 0.95), 0.05))]
    box = ([0, 0, 0], [10, 10, 6])
    write("figure12.json", scene(spheres, *box))
    for n in (4, 6, 8, 10, 12, 16, 18, 20, 22, 24):
        write(f"table3_{n:02}.json", scene(spheres[:n], *box))

    # All coordinates are exact in binary: four circles meet in every inner vertex, exactly.
    lattice = [sphere((i + 0.5, j + 0.5, 1), 0.25) for j in range(8) for i in range(8)]
    write("lattice.json", scene(lattice, [0, 0, 0], [8, 8, 3]))

    many = [sphere(c, r) for c, r in loose_spheres(400, 400, 40, (1.0, 3.0), (0.2, 0.9), 0.02)]
    write("hundreds.json", scene(many, [0, 0, 0], [40, 40, 8]))

    # A pitched roof, one wall that leans outwards and one that leans inwards, lamps and a pillar's head.
    write("room.json", scene(
        [plane([0, 1.5, 3], [0, -0.4, -1], "roof south"),
         plane([0, 1.5, 3], [0, 0.4, -1], "roof north"),
         plane([-0.25, 0, 0], [1, 0, 0.2], "west wall"),
         plane([4.75, 0, 0], [-1, 0, -0.15], "east wall"),
         sphere((1, 1, 1.9), 0.3, "lamp"),
         sphere((3, 2, 1.7), 0.2, "small lamp"),
         sphere((2.25, 1.25, 0.75), 0.25, "pillar")],
        [0, 0, 0], [4, 3, 4]))

    # The low spheres own disks inside the face of the large one: closed edges without vertices.
    write("island.json", scene(
        [sphere((0, 0, 3), 1.5, "large"),
         sphere((0.75, 0.5, 0.5), 0.125, "low"),
         sphere((-0.75, -0.5, 0.625), 0.0625, "lower still, a bit higher"),
         sphere((0.75, 0.5, 0.1875), 0.03125, "island in the island")],
        [-2, -2, 0], [2, 2, 4]))

    write("figure5.json", scene(
        [plane([0, 0, 1.5], [0.5, 0.5, -1], "O1"),
         cylinder((0.1, -0.35, 0.9), (1, 0.3, 0.1), 0.2, "O2"),
         sphere((-0.5, 0.5, 0.6), 0.25, "O3"),
         sphere((0.55, 0.45, 0.8), 0.3, "O4")],
        [-1, -1, 0], [1, 1, 2]))

    write("figure6.json", scene(
        [cylinder((0, -0.5, 0.7), (1, 0.2, 0.1), 0.15, "O1"),
         cylinder((-0.4, 0.2, 0.9), (0.3, 1, -0.15), 0.25, "O2"),
         cylinder((0.5, 0.3, 1.1), (-0.5, 1, 0.2), 0.2, "O3")],
        [-1, -1, 0], [1, 1, 2]))

    # Masts that lean over the square: their axes meet the base plane outside it.
    write("leaning.json", scene(
        [cylinder((2, 0, 0), (-1, 0.25, 1), 0.25, "east"),
         cylinder((-2.25, 0.5, 0), (1, -0.5, 0.75), 0.125, "west"),
         cylinder((0.25, 2.5, 0), (0.125, -1, 1.25), 0.375, "north"),
         cylinder((-0.5, -1.75, 0), (0.25, 1, 1), 0.0625, "south"),
         sphere((0, 0, 0.75), 0.25, "ball")],
        [-1, -1, 0], [1, 1, 3]))

    # Pipes: equal and unequal radii, all trisectors between neighbours are conics.
    write("parallel.json", scene(
        [cylinder((-0.75, 0, 0.75), (0.25, 1, 0), 0.25),
         cylinder((0, 0, 0.75), (0.25, 1, 0), 0.25),
         cylinder((0.625, 0, 1), (0.25, 1, 0), 0.5),
         cylinder((-0.375, 0, 1.75), (0.25, 1, 0), 0.125)],
        [-1, -1, 0], [1, 1, 2]))

    # Equal cylinders whose axes cross: their trisector falls into two conics, which cross in a node.
    write("crossing.json", scene(
        [cylinder((0, 0, 1), (1, 0, 0), 0.25),
         cylinder((0, 0, 1), (0, 1, 0), 0.25),
         sphere((0.625, 0.625, 0.5), 0.25)],
        [-1, -1, 0], [1, 1, 2]))

    # Rods that touch each other and a ball; nothing touches the base.
    write("tangent.json", scene(
        [cylinder((-0.25, 0, 0.75), (0, 1, 0), 0.25),
         cylinder((0.25, 0, 0.75), (0, 1, 0), 0.25),
         cylinder((0, 0.25, 1.25), (1, 0, 0), 0.25),
         sphere((0.75, -0.25, 0.75), 0.25)],
        [-1, -1, 0], [1, 1, 2]))

    write("pile_50.json", scene(pile(50, 5, 6, (0.4, 2.8)), [0, 0, 0], [6, 6, 4]))
    write("pile_500.json", scene(pile(500, 50, 20, (0.4, 2.8)), [0, 0, 0], [20, 20, 4]))


if __name__ == "__main__":
    main()
