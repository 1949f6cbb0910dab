#!/usr/bin/env python3
"""A picture of a cell: view_obj.py CELL.obj VIEW.png [--scene SCENE.json] [--sixth SIDE]
                                   [--from X Y Z] [--up X Y Z] [--size PIXELS]

Reads what `vcell compute SCENE.json -o CELL.obj` writes (with CELL.mtl beside it) and needs nothing but Python. With
its scene, base and objects are in the picture too: the base solid, objects as translucent as the cell and in
the colour of their faces; planes and cylinders end at the box. `--sixth +z` leaves of the cell around a ball what
the side +z of a cube about the ball's centre sees. Parallel projection, a light from the viewer's upper left, the
cell's edges as lines.
"""
import argparse
import itertools
import json
import math
import pathlib
import struct
import zlib

GREY = (0.8, 0.8, 0.8)
# How much of what lies behind each is hidden.
OPACITY = {"cell": 0.6, "box": 0.12, "base": 1.0, "object": 0.42, "plane": 0.2, "line": 1.0}


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def along(p, t, q):
    return tuple(a + t * b for a, b in zip(p, q))


def unit(a):
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


def across(axis):
    """Two unit vectors that make a right-handed frame with the unit vector `axis`."""
    least = min(range(3), key=lambda k: abs(axis[k]))
    x = unit(cross(axis, tuple(float(k == least) for k in range(3))))
    return x, cross(axis, x)


# ---- What is drawn: triangles as (colour, opacity, three of (point, normal)), lines as lists of points ----------

def read_materials(path):
    colours, name = {}, None
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word == "newmtl":
            name = rest[0]
        elif word == "Kd":
            colours[name] = tuple(float(x) for x in rest)
    return colours


def read_mesh(path):
    """Triangles, lines, and the colours of the owners of faces by name, as "object_7"."""
    points, normals, triangles, lines = [], [], [], []
    colours, colour, opacity = {}, GREY, OPACITY["cell"]
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word == "v":
            points.append(tuple(float(x) for x in rest))
        elif word == "vn":
            normals.append(tuple(float(x) for x in rest))
        elif word == "mtllib":
            colours = read_materials(path.parent / rest[0])
        elif word == "usemtl":
            colour = colours[rest[0]]
            opacity = OPACITY["cell" if rest[0].startswith("object") else "box"]
        elif word == "f":
            corners = [[int(i) - 1 for i in corner.split("//")] for corner in rest]
            triangles.append((colour, opacity, [(points[p], normals[n]) for p, n in corners]))
        elif word == "l":
            lines.append([points[int(i) - 1] for i in rest])
    return triangles, lines, colours


def quads(grid):
    """Triangles between the points of neighbouring rows."""
    for row, after in zip(grid, grid[1:]):
        for (a, b), (c, d) in zip(zip(row, row[1:]), zip(after, after[1:])):
            yield [a, c, b]
            yield [b, c, d]


def sphere_mesh(center, radius, steps=24):
    grid = []
    for i in range(steps + 1):
        turn = math.pi * i / steps
        ring = []
        for j in range(2 * steps + 1):
            round_ = math.pi * j / steps
            n = (math.sin(turn) * math.cos(round_), math.sin(turn) * math.sin(round_), math.cos(turn))
            ring.append((along(center, radius, n), n))
        grid.append(ring)
    return quads(grid)


def cylinder_mesh(point, axis, radius, reach, steps=48):
    axis = unit(axis)
    x, y = across(axis)
    grid = []
    for i in range(steps + 1):
        s = reach * (2 * i / steps - 1)
        ring = []
        for j in range(steps + 1):
            turn = 2 * math.pi * j / steps
            n = along(tuple(math.cos(turn) * c for c in x), math.sin(turn), y)
            ring.append((along(along(point, s, axis), radius, n), n))
        grid.append(ring)
    return quads(grid)


def plane_mesh(point, normal, reach):
    n = unit(normal)
    x, y = across(n)
    corners = [(along(along(point, s * reach, x), t * reach, y), n) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]


def clipped(corners, half_spaces):
    """What of a polygon lies where all functions of the point are positive."""
    for f in half_spaces:
        values = [f(p) for p, _ in corners]
        inside = []
        for (p, v), (q, w) in zip(zip(corners, values), zip(corners[1:] + corners[:1], values[1:] + values[:1])):
            if v >= 0:
                inside.append(p)
            if (v < 0) != (w < 0):
                t = v / (v - w)
                inside.append(tuple(along(a, t, tuple(d - c for c, d in zip(a, b))) for a, b in zip(p, q)))
        corners = inside
        if len(corners) < 3:
            return []
    return corners


def clipped_triangles(triangles, half_spaces):
    for colour, opacity, corners in triangles:
        polygon = clipped(list(corners), half_spaces)
        for b, c in zip(polygon[1:], polygon[2:]):
            yield colour, opacity, [polygon[0], b, c]


def clipped_line(line, half_spaces):
    """The pieces of a polyline."""
    for p, q in zip(line, line[1:]):
        low, high = 0.0, 1.0
        for f in half_spaces:
            v, w = f(p), f(q)
            if v < 0 and w < 0:
                high = -1.0
            elif (v < 0) != (w < 0):
                t = v / (v - w)
                low, high = (max(low, t), high) if v < 0 else (low, min(high, t))
        if low < high:
            step = tuple(b - a for a, b in zip(p, q))
            yield [along(p, low, step), along(p, high, step)]


def box_of(scene):
    low, high = scene["box"]["min"], scene["box"]["max"]
    sides = []
    for k in range(3):
        sides.append(lambda p, k=k: p[k] - low[k])
        sides.append(lambda p, k=k: high[k] - p[k])
    return sides


def sixth_of(scene, side):
    """The pyramid from the base ball's centre through a side of a cube about it, as "+z"."""
    center = scene["base"]["sphere"]["center"]
    k, sign = "xyz".index(side[1]), 1 if side[0] == "+" else -1
    return [lambda p, j=j, s=s: sign * (p[k] - center[k]) - s * (p[j] - center[j])
            for j, s in itertools.product({0, 1, 2} - {k}, (-1, 1))]


def solids(scene, colours):
    """Base and objects as triangles."""
    sides, reach = box_of(scene), 2 * math.dist(scene["box"]["min"], scene["box"]["max"])

    def mesh(entry):
        kind = next(k for k in ("plane", "sphere", "cylinder") if k in entry)
        o = entry[kind]
        if kind == "sphere":
            return kind, sphere_mesh(o["center"], o["radius"])
        middle = [(a + b) / 2 for a, b in zip(scene["box"]["min"], scene["box"]["max"])]
        if kind == "plane":
            n = unit(o["normal"])
            foot = along(middle, -dot(n, along(middle, -1, o["point"])), n)
            return kind, plane_mesh(foot, n, reach)
        axis = unit(o["axis"])
        foot = along(o["point"], dot(axis, along(middle, -1, o["point"])), axis)
        return kind, cylinder_mesh(foot, axis, o["radius"], reach / 2)

    for i, entry in [(None, scene["base"]), *enumerate(scene["objects"])]:
        if i == scene.get("base_object", -1):
            continue
        kind, triangles = mesh(entry)
        colour = GREY if i is None else colours.get(f"object_{i}", GREY)
        opacity = OPACITY["base" if i is None else "plane" if kind == "plane" else "object"]
        triangles = ((colour, opacity, corners) for corners in triangles)
        yield from triangles if kind == "sphere" else clipped_triangles(triangles, sides)


# ---- Drawing ------------------------------------------------------------------------------------------------

class Picture:
    """Every pixel keeps what covers it, as (depth towards the viewer, colour, opacity)."""

    def __init__(self, size):
        self.size = size
        self.covers = [None] * (size * size)

    def cover(self, at, depth, colour, opacity):
        if self.covers[at] is None:
            self.covers[at] = [(depth, colour, opacity)]
        else:
            self.covers[at].append((depth, colour, opacity))

    def triangle(self, corners, shades, colour, opacity):
        """Corners in pixels and depth; shades are interpolated. A pixel on a side that two triangles share
        belongs to one of them."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0:
            return
        low, high = max(0, math.ceil(min(ay, by, cy))), min(self.size - 1, math.floor(max(ay, by, cy)))
        for y in range(low, high + 1):
            # Where the line of pixels crosses the sides: half-open at the upper end, both in y and in x.
            crossings = []
            for (px, py), (qx, qy) in (((ax, ay), (bx, by)), ((bx, by), (cx, cy)), ((cx, cy), (ax, ay))):
                if (py <= y) != (qy <= y):
                    if py > qy:  # the same rounding from both sides
                        px, py, qx, qy = qx, qy, px, py
                    crossings.append(px + (y - py) * (qx - px) / (qy - py))
            if len(crossings) != 2:
                continue
            left, right = min(crossings), max(crossings)
            for x in range(max(0, math.ceil(left)), min(self.size, math.ceil(right))):
                u = ((bx - x) * (cy - y) - (cx - x) * (by - y)) / area
                v = ((cx - x) * (ay - y) - (ax - x) * (cy - y)) / area
                w = 1 - u - v
                shade = u * shades[0] + v * shades[1] + w * shades[2]
                self.cover(y * self.size + x, u * az + v * bz + w * cz,
                           (shade * colour[0], shade * colour[1], shade * colour[2]), opacity)

    def line(self, a, b, width, nearer):
        """Dark, `nearer` the viewer than it is, so that faces beside it do not hide it."""
        steps = max(1, math.ceil(2 * math.hypot(b[0] - a[0], b[1] - a[1])))
        depths = {}
        for k in range(steps + 1):
            x, y, z = (p + (q - p) * k / steps for p, q in zip(a, b))
            for i in range(max(0, math.ceil(y - width)), min(self.size - 1, math.floor(y + width)) + 1):
                for j in range(max(0, math.ceil(x - width)), min(self.size - 1, math.floor(x + width)) + 1):
                    if math.hypot(i - y, j - x) <= width:
                        at = i * self.size + j
                        depths[at] = max(depths.get(at, -math.inf), z + nearer)
        for at, depth in depths.items():
            self.cover(at, depth, (0.13, 0.13, 0.13), OPACITY["line"])

    def pixel(self, at):
        left, result = 1.0, [0.0, 0.0, 0.0]
        for _, colour, opacity in sorted(self.covers[at] or (), key=lambda cover: -cover[0]):
            result = [r + left * opacity * c for r, c in zip(result, colour)]
            left *= 1 - opacity
            if left < 0.01:
                break
        return [r + left for r in result]  # on white

    def write(self, path, samples):
        """A pixel of the file is the mean of samples x samples pixels."""
        size = self.size // samples
        rows = []
        for y in range(size):
            row = bytearray(b"\0")
            for x in range(size):
                block = [self.pixel((y * samples + i) * self.size + x * samples + j)
                         for i in range(samples) for j in range(samples)]
                row += bytes(round(255 * min(1, sum(p[k] for p in block) / len(block))) for k in range(3))
            rows.append(bytes(row))

        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)) +
                         chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) + chunk(b"IEND", b""))


def draw(mesh, picture, scene=None, sixth=None, viewer=(3, 2, 4), up=(0, 1, 0), size=480):
    triangles, lines, colours = read_mesh(mesh)
    if sixth:
        pyramid = sixth_of(scene, sixth)
        triangles = list(clipped_triangles(triangles, pyramid))
        lines = [piece for line in lines for piece in clipped_line(line, pyramid)]
    if scene:
        triangles += solids(scene, colours)
    out = unit(viewer)
    right = unit(cross(up, out))
    frame = (right, cross(out, right), out)
    light = unit((-0.4, 0.5, 1))

    def seen(p):
        return tuple(dot(axis, p) for axis in frame)

    places = [seen(p) for _, _, corners in triangles for p, _ in corners]
    low = [min(p[k] for p in places) for k in range(3)]
    high = [max(p[k] for p in places) for k in range(3)]
    samples = 2
    pixels = samples * size
    scale = 0.94 * pixels / max(high[0] - low[0], high[1] - low[1])

    def placed(p):
        x, y, z = seen(p)
        return (pixels / 2 + scale * (x - (low[0] + high[0]) / 2), pixels / 2 - scale * (y - (low[1] + high[1]) / 2),
                scale * z)

    def shade(n):
        # From both sides alike: what is translucent shows its inside.
        return 0.55 + 0.45 * abs(dot(light, seen(n)))

    image = Picture(pixels)
    for colour, opacity, corners in triangles:
        image.triangle([placed(p) for p, _ in corners], [shade(n) for _, n in corners], colour, opacity)
    for line in lines:
        for a, b in zip(line, line[1:]):
            image.line(placed(a), placed(b), 0.7 * samples, 0.004 * pixels)
    image.write(picture, samples)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("picture", type=pathlib.Path)
    parser.add_argument("--scene", type=pathlib.Path)
    parser.add_argument("--sixth", choices=[s + axis for axis in "xyz" for s in "-+"], metavar="SIDE")
    parser.add_argument("--from", dest="viewer", nargs=3, type=float, default=(3, 2, 4), metavar=("X", "Y", "Z"))
    parser.add_argument("--up", nargs=3, type=float, default=(0, 1, 0), metavar=("X", "Y", "Z"))
    parser.add_argument("--size", type=int, default=480)
    options = parser.parse_args()
    if options.sixth and not options.scene:
        parser.error("--sixth needs --scene")
    scene = json.loads(options.scene.read_text(encoding="utf-8-sig")) if options.scene else None
    draw(options.mesh, options.picture, scene, options.sixth, options.viewer, options.up, options.size)


if __name__ == "__main__":
    main()
