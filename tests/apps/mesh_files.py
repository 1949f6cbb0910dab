"""Meshes that the program writes as binary glTF and 3MF, read back by code that shares nothing with it.

mesh_files.py PROGRAM SCENES FOLDER
"""
import collections
import itertools
import json
import math
import pathlib
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile

faults = []


def check(is_so, what):
    if not is_so:
        faults.append(what)


def subtract(a, b):
    return tuple(x - y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def is_closed(triangles):
    """Does every directed side occur once, and its opposite once?"""
    sides = collections.Counter((t[k], t[(k + 1) % 3]) for t in triangles for k in range(3))
    return all(n == 1 and sides[b, a] == 1 for (a, b), n in sides.items())


def volume(triangles):
    return sum(dot(a, cross(b, c)) for a, b, c in triangles) / 6


# ---- Binary glTF ------------------------------------------------------------------------------------------------

class Glb:
    def __init__(self, path):
        data = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        check((magic, version, length) == (b"glTF", 2, len(data)), f"{path.name}: header")
        size, kind = struct.unpack_from("<I4s", data, 12)
        check(kind == b"JSON" and size % 4 == 0, f"{path.name}: first chunk")
        self.name, text = path.name, data[20:20 + size]
        self.json, self.padding = json.loads(text), text[text.rindex(b"}") + 1:]
        bin_size, kind = struct.unpack_from("<I4s", data, 20 + size)
        check(kind == b"BIN\0" and bin_size % 4 == 0 and 28 + size + bin_size == length, f"{path.name}: second chunk")
        self.bytes = data[28 + size:]
        check(self.json["buffers"] == [{"byteLength": bin_size}], f"{path.name}: buffer")
        check(self.json["asset"]["version"] == "2.0", f"{path.name}: asset")
        self.check_layout()
        self.check_accessors()
        self.check_scene()

    def check_layout(self):
        """Chunks of glTF 2.0 (4.4) are padded with blanks and zeros; views (3.6) lie in the buffer, one after the other."""
        check(not self.padding.strip(b" ") and not any(self.bytes[self.ends_of_views()[-1]:]), f"{self.name}: padding")
        end = 0
        for number, view in enumerate(self.json["bufferViews"]):
            begin = view.get("byteOffset", 0)
            check(view["buffer"] == 0 and view["byteLength"] > 0 and begin % 4 == 0, f"{self.name}: view {number}")
            check(end <= begin < end + 4 and not any(self.bytes[end:begin]), f"{self.name}: a gap before view {number}")
            end = begin + view["byteLength"]
            stride = view.get("byteStride", 4)
            check(4 <= stride <= 252 and stride % 4 == 0, f"{self.name}: stride of view {number}")
            check(view["target"] == 34962 or (view["target"] == 34963 and "byteStride" not in view), f"{self.name}: target of view {number}")
        check(end <= len(self.bytes) < end + 4, f"{self.name}: the buffer's length")

    def ends_of_views(self):
        return [view.get("byteOffset", 0) + view["byteLength"] for view in self.json["bufferViews"]]

    def check_accessors(self):
        """Whatever is there is used, and for one purpose; numbers are finite (3.6.2)."""
        uses = collections.defaultdict(set)
        for mesh in self.json["meshes"]:
            check(len(mesh["primitives"]) > 0, f"{self.name}: a mesh of nothing")
            for p in mesh["primitives"]:
                check(set(p) <= {"attributes", "indices", "material", "mode", "extras"}, f"{self.name}: {set(p)} of a primitive")
                check(set(p["attributes"]) <= {"POSITION", "NORMAL"}, f"{self.name}: attributes")
                for kind, number in [*p["attributes"].items(), *([("indices", p["indices"])] if "indices" in p else [])]:
                    uses[number].add(kind)
        accessors = self.json["accessors"]
        check(set(uses) == set(range(len(accessors))), f"{self.name}: accessors that nothing uses")
        check({a["bufferView"] for a in accessors} == set(range(len(self.json["bufferViews"]))), f"{self.name}: views that nothing uses")
        for number, a in enumerate(accessors):
            check(len(uses[number]) == 1 and set(a) <= {"bufferView", "byteOffset", "componentType", "count", "type", "min", "max"}, f"{self.name}: accessor {number}")
            values = self.accessor(number, 34963 if uses[number] == {"indices"} else 34962)
            if uses[number] == {"indices"}:
                check(all(i != 0xFFFFFFFF for i, in values), f"{self.name}: an index that restarts")
            else:
                check(all(math.isfinite(x) for v in values for x in v), f"{self.name}: a number that is not finite")

    def check_scene(self):
        """Nodes are trees (3.5.2), each reached once; factors of materials (3.9) are parts of one."""
        nodes = self.json["nodes"]
        reached, ahead = [], list(self.json["scenes"][self.json["scene"]]["nodes"])
        while ahead and len(reached) <= len(nodes):
            reached.append(ahead.pop())
            ahead += nodes[reached[-1]].get("children", [])
        check(sorted(reached) == list(range(len(nodes))), f"{self.name}: nodes are no tree")
        check(sorted(n["mesh"] for n in nodes if "mesh" in n) == list(range(len(self.json["meshes"]))), f"{self.name}: meshes of nodes")
        for node in nodes:
            check(abs(math.hypot(*node.get("rotation", (0, 0, 0, 1))) - 1) < 1e-9, f"{self.name}: a rotation that is none")
            check(all(math.isfinite(x) for x in node.get("translation", ())), f"{self.name}: a translation")
        for material in self.json["materials"]:
            pbr = material["pbrMetallicRoughness"]
            factors = [*pbr["baseColorFactor"], pbr.get("metallicFactor", 1), pbr.get("roughnessFactor", 1)]
            check(len(factors) == 6 and all(0 <= x <= 1 for x in factors), f"{self.name}: a material")
        used = {p["material"] for mesh in self.json["meshes"] for p in mesh["primitives"]}
        check(used == set(range(len(self.json["materials"]))), f"{self.name}: materials that nothing has")

    def accessor(self, number, target):
        a = self.json["accessors"][number]
        view = self.json["bufferViews"][a["bufferView"]]
        width, kind = {"SCALAR": (1, "I"), "VEC3": (3, "f")}[a["type"]]
        check(a["componentType"] == {"I": 5125, "f": 5126}[kind] and view["target"] == target, f"{self.name}: accessor {number}")
        step = view.get("byteStride", 4 * width)
        end = a["byteOffset"] + step * (a["count"] - 1) + 4 * width
        check(a["byteOffset"] % 4 == 0 and a["count"] > 0 and end <= view["byteLength"], f"{self.name}: accessor {number} in its view")
        at = view.get("byteOffset", 0) + a["byteOffset"]
        values = [struct.unpack_from(f"<{width}{kind}", self.bytes, at + step * i) for i in range(a["count"])]
        if "min" in a:
            for bound, of in (("min", min), ("max", max)):
                check(tuple(a[bound]) == tuple(of(v[k] for v in values) for k in range(width)), f"{self.name}: {bound} of accessor {number}")
        return values

    def cells(self):
        """Of each node with a mesh: name, triangles of points, edges as lists of points, in the scene's axes."""
        root = self.json["nodes"][self.json["scenes"][self.json["scene"]]["nodes"][0]]
        x, y, z, w = root["rotation"]
        # The quaternion turns (0, 0, 1) to glTF's (0, 1, 0).
        up = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        check(math.dist(up, (0, 1, 0)) < 1e-15, f"{self.name}: z is not upwards")
        for child in root["children"]:
            node = self.json["nodes"][child]
            mesh = self.json["meshes"][node["mesh"]]
            triangles, edges, neighbors = [], [], []
            for p in mesh["primitives"]:
                check(p["material"] < len(self.json["materials"]), f"{self.name}: material")
                check("min" in self.json["accessors"][p["attributes"]["POSITION"]], f"{self.name}: bounds")
                points = self.accessor(p["attributes"]["POSITION"], 34962)
                if p["mode"] == 3:
                    check("indices" not in p and len(points) > 1, f"{self.name}: strip")
                    edges.append(points)
                    continue
                check(p["mode"] == 4, f"{self.name}: mode")
                normals = self.accessor(p["attributes"]["NORMAL"], 34962)
                check(all(abs(dot(n, n) - 1) < 1e-6 for n in normals), f"{self.name}: normals are not unit")
                indices = [i for i, in self.accessor(p["indices"], 34963)]
                check(len(indices) % 3 == 0 and max(indices) < len(points) == len(normals), f"{self.name}: indices")
                check(set(indices) == set(range(len(points))), f"{self.name}: points that no triangle has")
                for corners in zip(*[iter(indices)] * 3):
                    a, b, c = (points[i] for i in corners)
                    across = cross(subtract(b, a), subtract(c, a))
                    length = math.sqrt(dot(across, across))
                    if length > 1e-6:
                        check(all(dot(across, normals[i]) > 0.5 * length for i in corners), f"{self.name}: a normal on the other side")
                    triangles.append((a, b, c))
                neighbors.append(p["extras"]["neighbor"])
            yield node["name"], node["translation"], triangles, edges, neighbors


# ---- 3MF --------------------------------------------------------------------------------------------------------

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


def objects_of_3mf(path, unit):
    """Of each object: name, type, triangles of points, materials of the triangles by name."""
    with zipfile.ZipFile(path) as archive:
        check(archive.testzip() is None, f"{path.name}: a check sum")
        check(archive.namelist() == ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"], f"{path.name}: names")
        types, relations, model = (ET.fromstring(archive.read(name)) for name in archive.namelist())
    check({e.get("Extension") for e in types} == {"rels", "model"}, f"{path.name}: types")
    check(relations[0].get("Target") == "/3D/3dmodel.model", f"{path.name}: relations")
    check(model.get("unit") == unit and model.tag == CORE + "model", f"{path.name}: model")
    bases = [b.get("name") for b in model.iter(CORE + "base")]
    built = [item.get("objectid") for item in model.iter(CORE + "item")]
    objects = list(model.iter(CORE + "object"))
    check(built == [o.get("id") for o in objects], f"{path.name}: what is built")
    for o in objects:
        points = [tuple(float(v.get(k)) for k in "xyz") for v in o.iter(CORE + "vertex")]
        rows = [(tuple(int(t.get(k)) for k in ("v1", "v2", "v3")), t.get("p1", o.get("pindex"))) for t in o.iter(CORE + "triangle")]
        check(all(len(set(corners)) == 3 for corners, _ in rows), f"{path.name}: a triangle that is none")
        check({i for corners, _ in rows for i in corners} == set(range(len(points))), f"{path.name}: points that no triangle has")
        check(is_closed([corners for corners, _ in rows]) == (o.get("type") == "model"), f"{path.name}: type of {o.get('name')}")
        yield o.get("name"), o.get("type"), [tuple(points[i] for i in corners) for corners, _ in rows], [bases[int(p)] for _, p in rows]


# ---- The files --------------------------------------------------------------------------------------------------

def main():
    program, scenes, folder = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
    folder.mkdir(parents=True, exist_ok=True)

    def vcell(*arguments):
        run = subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True, check=True)
        return run.stdout

    def measured(scene):
        names, values = (line.split("\t") for line in vcell("measure", scene).splitlines())
        return dict(zip(names, map(lambda v: float(v) if v[0].isdigit() else v, values)))

    # A ball among six: closed, a face for each of them.
    scene = scenes / "figure8.json"
    truth = measured(scene)
    for name in ("once", "twice"):
        vcell("compute", scene, "--chord", "0.2%", "-o", f"{name}.glb", "-o", f"{name}.3mf")
    for ending in ("glb", "3mf"):
        check((folder / f"once.{ending}").read_bytes() == (folder / f"twice.{ending}").read_bytes(), f"{ending}: other bytes the second time")
    (name, center, triangles, edges, neighbors), = Glb(folder / "once.glb").cells()
    corners = set(itertools.chain(*triangles))
    check(is_closed(triangles), "glb: a ball's cell is not closed")
    check(abs(volume(triangles) / truth["volume"] - 1) < 0.02, "glb: volume")
    check(sorted(neighbors) == [0, 1, 2, 3, 4, 5], "glb: neighbors")
    check(len(edges) == truth["edges"] and all(p in corners for edge in edges for p in edge), "glb: edges are not the triangles' sides")
    (title, kind, solid, materials), = objects_of_3mf(folder / "once.3mf", "millimeter")
    check(title == name and kind == "model" and len(solid) == len(triangles), "3mf: a ball's cell")
    check(abs(volume(solid) - volume(triangles)) < 1e-4, "3mf: volume is not the glb's")
    check(len(set(materials)) == 6, "3mf: materials")
    rounded = [subtract(p, center) for p in itertools.chain(*solid)]
    check({struct.unpack("<3f", struct.pack("<3f", *p)) for p in rounded} == corners, "glb: points are not the 3mf's about the middle")

    # Over a plane: open, or with walls and floor.
    scene = scenes / "three_spheres.json"
    truth = measured(scene)
    vcell("compute", scene, "--chord", "0.2%", "-o", "open.glb", "-o", "open.3mf")
    (_, _, triangles, _, _), = Glb(folder / "open.glb").cells()
    check(not is_closed(triangles), "glb: a cell over a plane is closed")
    check([o[1] for o in objects_of_3mf(folder / "open.3mf", "millimeter")] == ["surface"], "3mf: an open cell")
    vcell("compute", scene, "--chord", "0.2%", "--solid", "-o", "solid.GLB", "-o", "solid.3mf")
    (_, _, triangles, _, neighbors), = Glb(folder / "solid.GLB").cells()
    check(is_closed(triangles) and abs(volume(triangles) / truth["volume"] - 1) < 0.02, "glb: a solid over a plane")
    check(neighbors.count(-7) == 2, "glb: walls and base")
    (_, kind, solid, _), = objects_of_3mf(folder / "solid.3mf", "millimeter")
    check(kind == "model" and abs(volume(solid) / truth["volume"] - 1) < 0.02, "3mf: a solid over a plane")

    # All cells, one of them empty, beside each other.
    (folder / "balls.txt").write_text("100 0 0 0.5 A\n102 0 0 0.5 B&C\n100 2 0 0.25\n100.1 0 0 0.25 inner\n")
    vcell("diagram", "balls.txt", "--box", "98", "-2", "-2", "104", "4", "2", "-o", "all.glb", "-o", "all.3mf")
    cells = list(Glb(folder / "all.glb").cells())
    check([c[0] for c in cells] == ["cell 0 (A)", "cell 1 (B&C)", "cell 2"], "glb: names")
    check(all(is_closed(c[2]) for c in cells), "glb: cells of a diagram are not closed")
    check(abs(sum(volume(c[2]) for c in cells) / 144 - 1) < 0.005, "glb: volumes do not add up")
    solids = list(objects_of_3mf(folder / "all.3mf", "millimeter"))
    check([s[0] for s in solids] == [c[0] for c in cells] and all(s[1] == "model" for s in solids), "3mf: names")
    check(abs(sum(volume(s[2]) for s in solids) / 144 - 1) < 0.005, "3mf: volumes do not add up")
    check(len({m for s in solids for m in s[3]}) == 3, "3mf: cells beside each other have one colour")

    print(*faults, sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
