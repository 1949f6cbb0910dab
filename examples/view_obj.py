#!/usr/bin/env python3
"""A picture of a mesh: view_obj.py CELL.obj VIEW.png [--from X Y Z] [--up X Y Z] [--size PIXELS]

Reads what `vcell compute SCENE -o CELL.obj` writes (with CELL.mtl beside it) and needs nothing but Python. Parallel
projection, a light from the viewer's upper left, the cell's edges as lines.
"""
import argparse
import math
import pathlib
import struct
import zlib


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


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
    """Points, normals, triangles as (colour, corners of (point, normal)), polylines."""
    points, normals, triangles, lines = [], [], [], []
    colours, colour = {}, (0.8, 0.8, 0.8)
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
        elif word == "f":
            triangles.append((colour, [tuple(int(i) - 1 for i in corner.split("//")) for corner in rest]))
        elif word == "l":
            lines.append([int(i) - 1 for i in rest])
    return points, normals, triangles, lines


class Picture:
    def __init__(self, size):
        self.size = size
        self.depth = [-math.inf] * (size * size)
        self.pixels = [(1.0, 1.0, 1.0)] * (size * size)

    def triangle(self, corners, shades, colour):
        """Corners in pixels and depth, towards the viewer; shades are interpolated."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0:
            return
        low, high = max(0, math.ceil(min(ay, by, cy))), min(self.size - 1, math.floor(max(ay, by, cy)))
        left, right = max(0, math.ceil(min(ax, bx, cx))), min(self.size - 1, math.floor(max(ax, bx, cx)))
        for y in range(low, high + 1):
            for x in range(left, right + 1):
                u = ((bx - x) * (cy - y) - (cx - x) * (by - y)) / area
                v = ((cx - x) * (ay - y) - (ax - x) * (cy - y)) / area
                w = 1 - u - v
                if u < 0 or v < 0 or w < 0:
                    continue
                z, at = u * az + v * bz + w * cz, y * self.size + x
                if z > self.depth[at]:
                    shade = u * shades[0] + v * shades[1] + w * shades[2]
                    self.depth[at] = z
                    self.pixels[at] = tuple(shade * c for c in colour)

    def line(self, a, b, width, nearer):
        """Dark, where nothing lies before it by more than `nearer`."""
        steps = max(1, math.ceil(2 * math.hypot(b[0] - a[0], b[1] - a[1])))
        for k in range(steps + 1):
            x, y, z = (p + (q - p) * k / steps for p, q in zip(a, b))
            for i in range(math.ceil(y - width), math.floor(y + width) + 1):
                for j in range(math.ceil(x - width), math.floor(x + width) + 1):
                    inside = 0 <= i < self.size and 0 <= j < self.size and math.hypot(i - y, j - x) <= width
                    if inside and z + nearer > self.depth[i * self.size + j]:
                        self.pixels[i * self.size + j] = (0.13, 0.13, 0.13)

    def write(self, path, samples):
        """A pixel of the file is the mean of samples x samples pixels."""
        size = self.size // samples
        rows = []
        for y in range(size):
            row = bytearray(b"\0")
            for x in range(size):
                block = [self.pixels[(y * samples + i) * self.size + x * samples + j]
                         for i in range(samples) for j in range(samples)]
                row += bytes(round(255 * min(1, sum(p[k] for p in block) / len(block))) for k in range(3))
            rows.append(bytes(row))

        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

        path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)) +
                         chunk(b"IDAT", zlib.compress(b"".join(rows), 9)) + chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("picture", type=pathlib.Path)
    parser.add_argument("--from", dest="viewer", nargs=3, type=float, default=(3, 2, 4), metavar=("X", "Y", "Z"))
    parser.add_argument("--up", nargs=3, type=float, default=(0, 1, 0), metavar=("X", "Y", "Z"))
    parser.add_argument("--size", type=int, default=480)
    arguments = parser.parse_args()

    points, normals, triangles, lines = read_mesh(arguments.mesh)
    out = unit(arguments.viewer)
    right = unit(cross(arguments.up, out))
    frame = (right, cross(out, right), out)
    light = unit((-0.4, 0.5, 1))
    seen = [tuple(dot(axis, p) for axis in frame) for p in points]
    low = [min(p[k] for p in seen) for k in range(3)]
    high = [max(p[k] for p in seen) for k in range(3)]
    samples = 2
    size = samples * arguments.size
    scale = 0.94 * size / max(high[0] - low[0], high[1] - low[1])

    def placed(p):
        return (size / 2 + scale * (p[0] - (low[0] + high[0]) / 2),
                size / 2 - scale * (p[1] - (low[1] + high[1]) / 2), scale * p[2])

    places = [placed(p) for p in seen]
    picture = Picture(size)
    for colour, corners in triangles:
        shades = [0.55 + 0.45 * max(0, dot(light, [dot(axis, normals[n]) for axis in frame])) for _, n in corners]
        picture.triangle([places[p] for p, _ in corners], shades, colour)
    for line in lines:
        for a, b in zip(line, line[1:]):
            picture.line(places[a], places[b], 0.7 * samples, 0.01 * size)
    picture.write(arguments.picture, samples)


if __name__ == "__main__":
    main()
