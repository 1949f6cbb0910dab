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


if __name__ == "__main__":
    main()
