#!/usr/bin/env python3
"""Writes the scenes of examples/scenes. Deterministic: run again, it writes the same files.

    make_scenes.py [--molecules FOLDER] [--check]

The generator is written out below, so that no library's version changes the scenes. The scenes of molecules
are made only from a FOLDER of NAME.xyzr. With --check nothing is written: the exit status is 1 if any file
differs from what would be, or is a scene that nobody makes (atom_*.json may be there without their molecules).
"""
import argparse
import itertools
import json
import math
import pathlib

SCENES = pathlib.Path(__file__).resolve().parent / "scenes"
made = {}  # by name: the file's text


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


def hollow_sphere(center, radius, name=None):
    entry = {"hollow_sphere": {"center": center, "radius": radius}}
    if name:
        entry["name"] = name
    return entry


def hollow_cylinder(point, axis, radius, name=None):
    entry = {"hollow_cylinder": {"point": point, "axis": axis, "radius": radius}}
    if name:
        entry["name"] = name
    return entry


def hollow_cone(apex, axis, radius, slant, name=None):
    entry = {"hollow_cone": {"apex": apex, "axis": axis, "radius": radius, "slant": slant}}
    if name:
        entry["name"] = name
    return entry


def scene(objects, low, high, base=None):
    return {
        "vcell": 1,
        "base": base or {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}},
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
    if "base_object" in content:
        lines.append(f'  "base_object": {content["base_object"]},')
    probe = f',\n  "probe": {content["probe"]}' if "probe" in content else ""
    lines.append(f'  "box": {json.dumps(content["box"])}{probe}')
    lines.append("}")
    made[name] = "\n".join(lines) + "\n"


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


def unit_ball():
    return sphere((0, 0, 0), 1, "base")


def skew_tubes(count, seed, distance, base_radius):
    """Tubes around the z axis, none parallel to another, that leave room for each other and for the base."""
    random, gap = Random(seed), 0.02
    tubes = []
    while len(tubes) < count:
        turn = random.uniform(0, 2 * math.pi)
        point = [random.uniform(*distance) * f(turn) for f in (math.cos, math.sin)] + [0]
        axis = [random.uniform(-0.35, 0.35), random.uniform(-0.35, 0.35), 1]
        length = math.hypot(*axis)
        axis = [x / length for x in axis]
        radius = random.uniform(0.08, 0.2)
        others = tubes + [([0, 0, 0], [0, 0, 1], base_radius)]
        if all(distance_of_axes(point, axis, q, b) > radius + r + gap for q, b, r in others):
            tubes.append((point, axis, radius))
    return [cylinder(p, a, r) for p, a, r in tubes]


def molecule(path, count=60):
    """The ball nearest to the middle of a molecule among the `count` balls whose surfaces are nearest to it."""
    balls = [[float(x) for x in line.split()] for line in path.read_text().splitlines()]
    middle = [sum(b[k] for b in balls) / len(balls) for k in range(3)]
    base = min(balls, key=lambda b: math.dist(b[:3], middle))
    near = sorted(balls, key=lambda b: math.dist(b[:3], base[:3]) - b[3])
    near = [b for b in near if b is not base][:count]
    low = [min(b[k] - b[3] for b in near) for k in range(3)]
    high = [max(b[k] + b[3] for b in near) for k in range(3)]
    return scene([sphere(b[:3], b[3]) for b in near], [round(x, 3) for x in low], [round(x, 3) for x in high],
                 sphere(base[:3], base[3]))


def around_spheres():
    # A ball among three balls, of whose cell the figure shows the sixth over the cube's side +z.
    write("figure7.json", scene(
        [sphere((0.75, 0.25, 2.75), 0.75, "O1"),
         sphere((-1.5, 0.75, 2.25), 0.5, "O2"),
         sphere((0.25, -1.75, 2), 0.25, "O3")],
        [-4, -4, -4], [4, 4, 4], unit_ball()))
    write("figure8.json", scene(
        [sphere((2.5, 0.5, 0.25), 0.75, "O1"),
         sphere((-2.25, -0.75, 0.5), 0.5, "O2"),
         sphere((0.25, 2.5, -0.5), 1, "O3"),
         sphere((-0.5, -2, -0.25), 0.25, "O4"),
         sphere((-0.25, 0.25, 2.25), 0.5, "O5"),
         sphere((0.5, -0.25, -2.75), 0.75, "O6")],
        [-4, -4, -4], [4, 4, 4], unit_ball()))
    write("figure9.json", scene(
        [plane([0, 0, -2], [0.25, 0.125, 1], "O1"),
         plane([-2.25, 0, 0], [1, -0.25, 0.375], "O2"),
         sphere((2.25, 0.5, 0.25), 0.75, "O3"),
         sphere((-0.5, 1.5, 2), 0.5, "O4")],
        [-4, -4, -4], [4, 4, 4], unit_ball()))
    write("two_balls_plane.json", scene(
        [sphere((3, 0.5, 0.25), 1, "O1"),
         sphere((-1, 2.75, 1), 0.75, "O2"),
         plane([0, 0, -2.5], [0.25, 0.125, 1], "O3")],
        [-5, -5, -5], [5, 5, 5], unit_ball()))
    write("four_balls_two_planes.json", scene(
        [sphere((2.5, 0.5, 0.25), 0.75, "O1"),
         sphere((-1, 2.25, 1), 0.5, "O2"),
         sphere((-2, -1.5, 1.25), 1.25, "O3"),
         sphere((0.5, -2, -0.75), 0.25, "O4"),
         plane([0, 0, -2.5], [0.25, 0.125, 1], "O5"),
         plane([0, 0, 3], [-0.25, 0.5, -1], "O6")],
        [-4, -4, -4], [4, 4, 4], unit_ball()))
    write("ball_tube_plane.json", scene(
        [sphere((2.5, 0.5, 0.25), 0.75, "O1"),
         cylinder((-2, 0, 0.5), (0.25, 1, 0.125), 0.5, "O2"),
         plane([0, 0, -2.5], [0.25, 0.125, 1], "O3")],
        [-4, -4, -4], [4, 4, 4], unit_ball()))
    # Exactly symmetric: six walls or corners of the cell meet in four, three, or five faces.
    axes = [[s * (k == i) for k in range(3)] for i in range(3) for s in (-1, 1)]
    corners = [list(c) for c in itertools.product((-1, 1), repeat=3)]
    write("octahedron.json", scene([sphere([3 * x for x in a], 0.5) for a in axes],
                                   [-4, -4, -4], [4, 4, 4], unit_ball()))
    write("cube.json", scene([sphere([2 * x for x in c], 0.5) for c in corners],
                             [-4, -4, -4], [4, 4, 4], unit_ball()))
    golden = (1 + math.sqrt(5)) / 2
    icosahedron = [[s * c for c in (0, 1, t)] for s in (-1, 1) for t in (-golden, golden)]
    icosahedron = [[v[(k + i) % 3] for k in range(3)] for i in range(3) for v in icosahedron]
    write("icosahedron.json", scene([sphere([1.5 * x for x in v], 0.5) for v in icosahedron],
                                    [-4, -4, -4], [4, 4, 4], unit_ball()))
    write("cage.json", scene(
        [cylinder([2 * x for x in a], axes[(2 * (i // 2) + 2) % 6], 0.5) for i, a in enumerate(axes)],
        [-4, -4, -4], [4, 4, 4], unit_ball()))
    # Two faces that meet in a closed edge without a vertex.
    write("between.json", scene(
        [sphere((0, 0, 5), 4, "above"), sphere((0, 0, -5), 4, "below")],
        [-2, -2, -2], [2, 2, 2], sphere((0, 0, 0), 0.25, "base")))
    write("flat.json", scene(
        [sphere((math.cos(t) * d, math.sin(t) * d, 0), r)
         for t, d, r in [(0, 3, 1), (1.25, 2.5, 0.5), (2.25, 3, 0.75), (3.5, 2.25, 0.25), (4.75, 3.25, 1.25)]],
        [-4, -4, -4], [4, 4, 4], unit_ball()))


def around_cylinders():
    base = cylinder((0, 0, 0), (0, 0, 1), 0.5, "base")
    # A tube in the wedge of two planes whose crest is across it: they meet in an ellipse all around, but for
    # where the ball comes between them with two curves of degree four.
    write("figure10.json", scene(
        [plane([2.5, 0, 0], [5, 0, 12], "O1"),
         plane([2.5, 0, 0], [5, 0.5, -12], "O2"),
         sphere((-0.5, -1.75, 0.125), 0.5, "O3")],
        [-3, -2.5, -0.75], [2.25, 2.5, 0.75], base))
    write("tube_three_balls_plane.json", scene(
        [sphere((1.5, 0.25, 0.5), 0.5, "O1"),
         sphere((-0.75, 1.25, -0.75), 0.375, "O2"),
         sphere((-0.5, -1.5, 0.25), 0.75, "O3"),
         plane([-2, 0, 0], [1, 0.25, 0.125], "O4")],
        [-3, -3, -2], [3, 3, 2], base))
    write("three_tubes.json", scene(
        [cylinder((1.5, 0, 0.25), (0.125, 1, 0.25), 0.375, "O1"),
         cylinder((-1.25, 0.5, 0), (0.25, 0.5, 1), 0.25, "O2"),
         cylinder((0, -1.5, -0.5), (1, 0.125, 0.125), 0.5, "O3")],
        [-3, -3, -2], [3, 3, 2], base))
    write("bundle.json", scene(skew_tubes(20, 20, (1, 3.5), 0.5), [-4, -4, -3], [4, 4, 3], base))


def rained(count, seed, wall, radii, rest):
    """Balls that fall into a tube about the z axis one by one, each in the lowest of some places, and stay
    where they touch the first other one, or at the height rest(distance from the axis, radius)."""
    random = Random(seed)
    balls = []
    while len(balls) < count:
        r = random.uniform(*radii)
        best = None
        for _ in range(48):
            x, y = (random.uniform(r - wall, wall - r) for _ in range(2))
            if math.hypot(x, y) > wall - r:
                continue
            z = rest(math.hypot(x, y), r)
            for (a, b, c), s in balls:
                across = (x - a) ** 2 + (y - b) ** 2
                if across < (r + s) ** 2:
                    z = max(z, c + math.sqrt((r + s) ** 2 - across))
            if best is None or z < best[0][2]:
                best = ((x, y, z), r)
        if best:
            balls.append(best)
    return balls


def in_vessels():
    write("vessel.json", scene(
        [hollow_sphere([0, 0, 0], 2, "vessel"),
         sphere((-0.75, 0.5, 0.25), 0.5),
         sphere((0.25, -0.75, 0.5), 0.375),
         sphere((0, 0.25, -1.25), 0.25)],
        [-2.5, -2.5, -2.5], [2.5, 2.5, 2.5], sphere((0.75, 0.5, 0.25), 0.5)))

    # The box ends above the uppermost ball. Seed 240: the base lies at the wall, half-way up.
    wall = 4
    balls = rained(240, 240, wall, (0.45, 0.55), lambda away, r: r + 0.0625)
    top = math.ceil(max(c[2] + r for c, r in balls))
    base = min(range(len(balls)), key=lambda i: wall - math.hypot(*balls[i][0][:2]) - balls[i][1]
               + abs(balls[i][0][2] - top / 2))
    silo = scene([sphere(c, r) for c, r in balls] +
                 [hollow_cylinder([0, 0, 0], [0, 0, 1], wall, "wall"), plane([0, 0, 0], [0, 0, 1], "floor")],
                 [-4.5, -4.5, -0.5], [4.5, 4.5, top], sphere(*balls[base]))
    silo["base_object"] = base
    write("silo.json", silo)

    # A cone below, with its apex in 0 and 3/5 the sine of half its angle, that a plane closes at z = 1: balls
    # stay clear of both walls by 1/16. The tube on top is as wide as the cone is at z = 4. Of the balls in
    # the cone the base is nearest to its wall.
    sine, cosine, wall, outlet, gap = 0.6, 0.8, 3, 1, 0.0625

    def above_cone(away, r):
        return max(outlet + r + gap, (r + gap + cosine * away) / sine)

    balls = rained(120, 120, wall - gap, (0.4, 0.5), above_cone)
    top = math.ceil(max(c[2] + r for c, r in balls))
    base = min((i for i, (c, r) in enumerate(balls) if 2 < c[2] < 3),
               key=lambda i: sine * balls[i][0][2] - cosine * math.hypot(*balls[i][0][:2]) - balls[i][1])
    hopper = scene([sphere(c, r) for c, r in balls] +
                   [hollow_cone([0, 0, 0], [0, 0, 1], 3, 5, "hopper"),
                    hollow_cylinder([0, 0, 0], [0, 0, 1], wall, "bin"),
                    plane([0, 0, outlet], [0, 0, 1], "outlet")],
                   [-3.5, -3.5, outlet - 0.5], [3.5, 3.5, top], sphere(*balls[base]))
    hopper["base_object"] = base
    write("hopper.json", hopper)

    # Five fibres along a tube or leaning a little, clear of each other and of the wall by 0.1 in the box, and
    # balls between them that keep clear of all by 0.02. The base is the third fibre.
    random = Random(24)
    wall, half = 2, 1
    fibres = [((0.75 * math.cos(k * 2 * math.pi / 5) * (1.3 if k % 2 else 1),
                0.75 * math.sin(k * 2 * math.pi / 5) * (1.3 if k % 2 else 1), 0),
               (0, 0, 1) if k in (0, 3) else (random.uniform(-0.15, 0.15), random.uniform(-0.15, 0.15), 1),
               random.uniform(0.1, 0.2)) for k in range(5)]

    def from_axis(p, fibre):
        (x, y, _), (a, b, _), r = fibre
        u, v = p[0] - x - a * p[2], p[1] - y - b * p[2]
        # Across (a, b, 1).
        along = (u * a + v * b) / (1 + a * a + b * b)
        return math.sqrt(u * u + v * v - along * along * (1 + a * a + b * b)) - r

    balls = []
    while len(balls) < 24:
        c = [random.uniform(-wall, wall), random.uniform(-wall, wall), random.uniform(-half, half)]
        r = random.uniform(0.12, 0.3)
        if (math.hypot(c[0], c[1]) + r + 0.02 < wall and abs(c[2]) + r + 0.02 < half
                and all(from_axis(c, f) > r + 0.02 for f in fibres)
                and all(math.dist(c, d) > r + s + 0.02 for d, s in balls)):
            balls.append((c, r))
    in_tube = scene([cylinder(*f) for f in fibres] + [sphere(c, r) for c, r in balls] +
                    [hollow_cylinder([0, 0, 0], [0, 0, 1], wall, "wall")],
                    [-2.25, -2.25, -half], [2.25, 2.25, half], cylinder(*fibres[2]))
    in_tube["base_object"] = 2
    write("fibres_in_tube.json", in_tube)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--molecules", type=pathlib.Path, metavar="FOLDER")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    around_spheres()
    around_cylinders()
    for path in sorted(options.molecules.glob("????.xyzr")) if options.molecules else []:
        write(f"atom_{path.stem.lower()}.json", molecule(path))

    write("figure1.json", scene(
        [sphere((-0.4, -0.2, 0.75), 0.3, "O1"),
         sphere((0.5, 0.25, 0.55), 0.2, "O2")],
        [-1, -1, 0], [1, 1, 2]))
    write("figure2.json", scene(
        [sphere((-0.5, -0.4, 0.7), 0.3, "O1"),
         sphere((0.55, -0.3, 0.6), 0.2, "O2"),
         sphere((0.1, 0.5, 0.8), 0.35, "O3")],
        [-1, -1, 0], [1, 1, 2]))

    write("three_spheres.json", scene(
        [sphere((-0.45, -0.3, 0.75), 0.3, "O1"),
         sphere((0.5, -0.35, 0.6), 0.2, "O2"),
         sphere((0.05, 0.5, 0.9), 0.4, "O3")],
        [-1, -1, 0], [1, 1, 2]))

    write("six_spheres.json", scene(
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

    in_vessels()

    probed = scene(
        [sphere((2, 0.5, 0.25), 0.5),
         cylinder((0, 2, 0), (1, 0.25, 0.5), 0.25),
         sphere((-1, -1.5, 1), 0.25),
         sphere((1, -1, -1.25), 0.25)],
        [-2.25, -2.25, -2.25], [2.25, 2.25, 2.25], cylinder((0, 0, 0), (0.25, 0, 1), 0.25))
    probed["probe"] = 1
    write("probe.json", probed)

    if options.check:
        files = {path.name: path.read_text(encoding="utf-8") for path in SCENES.glob("*.json")}
        wrong = [name for name, text in made.items() if files.get(name) != text]
        wrong += [name for name in files if name not in made and not name.startswith("atom_")]
        for name in sorted(wrong):
            print(f"{name} is not what make_scenes.py writes")
        return 1 if wrong else 0
    SCENES.mkdir(exist_ok=True)
    for name, text in made.items():
        (SCENES / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
