"""STEP files judged by themselves: step.py PROGRAM FOLDER SCENES...

Reads what PROGRAM writes of each scene, and of a whole diagram, and believes its text alone: every reference is there, every edge is used once
each way in a closed shell whose loops run head to tail, curves end at their vertices, a curve in a surface's parameters is
the curve in space at equal parameters within the uncertainty that the file states, and the volume by the divergence
theorem, by quadrature of its own, is the one that `PROGRAM measure` states. A file with a face turned, and one with a pole
moved, must fail. Needs numpy; exit status 77 without it.
"""
import collections
import csv
import pathlib
import re
import subprocess
import sys

try:
    import numpy as np
except ImportError:
    print("numpy is not installed")
    sys.exit(77)

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)
PARTS = 4  # of a curve's span, for quadrature


class Fault(Exception):
    pass


def parsed(text):
    """Nested lists of a parameter list's text: numbers, "#n" as integers in a tuple, and words as they are."""
    tokens = re.findall(r"'(?:[^']|'')*'|#\d+|\.[A-Z_0-9]+\.|[-+]?\d+\.?\d*(?:E[-+]?\d+)?|[A-Z_0-9]+|[(),$*]", text)
    stack = [[]]
    for t in tokens:
        if t == "(":
            stack.append([])
        elif t == ")":
            inner = stack.pop()
            stack[-1].append(inner)
        elif t == ",":
            continue
        elif t[0] == "#":
            stack[-1].append(("#", int(t[1:])))
        elif re.match(r"[-+\d]", t):
            stack[-1].append(float(t))
        else:
            stack[-1].append(t)
    return stack[0]


class File:
    def __init__(self, text):
        self.parts = {}  # number -> {entity: its parameters}
        for number, body in re.findall(r"^#(\d+)=(.*);$", text, re.M):
            words = parsed(body)
            words = words[0] if isinstance(words[0], list) else words
            self.parts[int(number)] = {words[i]: words[i + 1] for i in range(0, len(words), 2)}
        for entities in self.parts.values():
            self.check_references(list(entities.values()))

    def check_references(self, value):
        if isinstance(value, tuple):
            if value[1] not in self.parts:
                raise Fault(f"#{value[1]} is not there")
        elif isinstance(value, list):
            for v in value:
                self.check_references(v)

    def get(self, reference, entity):
        return self.parts[reference[1]][entity]

    def all(self, entity):
        return [(("#", n), e[entity]) for n, e in self.parts.items() if entity in e]

    def point(self, reference):
        return self.get(reference, "CARTESIAN_POINT")[1]

    def direction(self, reference):
        return np.array(self.get(reference, "DIRECTION")[1])


def full(multiplicities, knots):
    return np.repeat(np.array(knots), np.array(multiplicities, dtype=int))


def basis(degree, knots, t):
    """Values of all B-splines at all t, and their derivatives: the recursion of Cox and de Boor."""
    t = np.clip(np.atleast_1d(t), knots[0], knots[-1])
    last = np.searchsorted(knots, knots[-1]) - 1
    span = np.minimum(np.searchsorted(knots, t, side="right") - 1, last)
    n = np.zeros((len(t), len(knots) - 1))
    n[np.arange(len(t)), span] = 1
    derivative = n
    for p in range(1, degree + 1):
        count = len(knots) - 1 - p
        left = knots[p:p + count] - knots[:count]
        right = knots[p + 1:p + 1 + count] - knots[1:1 + count]
        a = np.divide(1, left, out=np.zeros(count), where=left > 0)
        b = np.divide(1, right, out=np.zeros(count), where=right > 0)
        if p == degree:
            derivative = p * (n[:, :-1] * a - n[:, 1:] * b)
        n = n[:, :-1] * a * (t[:, None] - knots[:count]) + n[:, 1:] * b * (knots[p + 1:p + 1 + count] - t[:, None])
    return n, derivative


class Curve:
    def __init__(self, file, reference):
        entity = file.parts[reference[1]]
        degree, poles = entity["B_SPLINE_CURVE"][:2]
        multiplicities, knots = entity["B_SPLINE_CURVE_WITH_KNOTS"][:2]
        weights = np.array(entity["RATIONAL_B_SPLINE_CURVE"][0])
        self.degree, self.spans, self.knots = int(degree), knots, full(multiplicities, knots)
        self.points = np.column_stack([np.array([file.point(p) for p in poles]) * weights[:, None], weights])
        if len(self.knots) != len(poles) + self.degree + 1 or (weights <= 0).any() or (np.diff(knots) <= 0).any():
            raise Fault(f"#{reference[1]} is no rational B-spline curve")

    def at(self, t):
        """Points and derivatives."""
        n, d = basis(self.degree, self.knots, t)
        h, dh = n @ self.points, d @ self.points
        p = h[:, :-1] / h[:, -1:]
        return p, (dh[:, :-1] - dh[:, -1:] * p) / h[:, -1:]


class Spline:
    def __init__(self, file, entity):
        du, dv, poles = entity["B_SPLINE_SURFACE"][:3]
        mu, mv, ku, kv = entity["B_SPLINE_SURFACE_WITH_KNOTS"][:4]
        weights = np.array(entity["RATIONAL_B_SPLINE_SURFACE"][0])
        self.degrees, self.knots = (int(du), int(dv)), (full(mu, ku), full(mv, kv))
        points = np.array([[file.point(p) for p in row] for row in poles])
        self.points = np.concatenate([points * weights[:, :, None], weights[:, :, None]], axis=2)
        self.breaks = np.array(ku)

    def flux(self, u, v):
        """A third of the integral of the normal times the place, from where the surface begins to u, for each (u, v)."""
        rows = [np.einsum("nj,ijc->nic", b, self.points) for b in basis(self.degrees[1], self.knots[1], v)]

        def integrand(subscripts, t):
            b = basis(self.degrees[0], self.knots[0], t.ravel())
            b = [x.reshape(t.shape + (-1,)) for x in b]
            h = [np.einsum(subscripts, x, y) for x, y in ((b[0], rows[0]), (b[1], rows[0]), (b[0], rows[1]))]
            p = h[0][..., :3] / h[0][..., 3:]
            du, dv = ((d[..., :3] - d[..., 3:] * p) / h[0][..., 3:] for d in h[1:])
            return np.sum(p * np.cross(du, dv), axis=-1) / 3

        half = 0.5 * np.diff(self.breaks)
        whole = integrand("kgi,nic->nkgc", self.breaks[:-1, None] + half[:, None] * (NODES + 1)) @ WEIGHTS * half
        until = np.concatenate([np.zeros((len(u), 1)), np.cumsum(whole, axis=1)], axis=1)
        k = np.clip(np.searchsorted(self.breaks, u, side="right") - 1, 0, len(half) - 1)
        part = 0.5 * (u - self.breaks[k])
        rest = integrand("ngi,nic->ngc", self.breaks[k][:, None] + part[:, None] * (NODES + 1)) @ WEIGHTS * part
        return until[np.arange(len(u)), k] + rest

    def at(self, u, v):
        """Points and both derivatives."""
        (nu, du), (nv, dv) = (basis(g, k, x) for g, k, x in zip(self.degrees, self.knots, (u, v)))
        h = [np.einsum("ai,aj,ijc->ac", a, b, self.points) for a, b in ((nu, nv), (du, nv), (nu, dv))]
        p = h[0][:, :3] / h[0][:, 3:]
        return [p] + [(d[:, :3] - d[:, 3:] * p) / h[0][:, 3:] for d in h[1:]]


class Plane:
    def __init__(self, file, entity):
        placement = file.get(entity["PLANE"][1], "AXIS2_PLACEMENT_3D")
        self.origin, axis, self.x = (np.array(file.point(placement[1])), file.direction(placement[2]),
                                     file.direction(placement[3]))
        self.y = np.cross(axis, self.x)

    def flux(self, u, v):
        return self.origin @ np.cross(self.x, self.y) / 3 * u

    def at(self, u, v):
        u, v = np.atleast_1d(u)[:, None], np.atleast_1d(v)[:, None]
        return [self.origin + u * self.x + v * self.y, np.broadcast_to(self.x, (len(u), 3)),
                np.broadcast_to(self.y, (len(u), 3))]


def judged(text):
    """Volume and uncertainty of a file without a fault."""
    file = File(text)
    uncertainty = file.all("UNCERTAINTY_MEASURE_WITH_UNIT")[0][1][1]
    if not isinstance(uncertainty, float):  # LENGTH_MEASURE(x)
        uncertainty = file.all("UNCERTAINTY_MEASURE_WITH_UNIT")[0][1][1][0]
    surfaces, edges, volume = {}, {}, 0
    for reference, _ in file.all("PCURVE"):
        on = file.get(reference, "PCURVE")[1]
        if on not in surfaces:
            entity = file.parts[on[1]]
            surfaces[on] = Plane(file, entity) if "PLANE" in entity else Spline(file, entity)
    for reference, (_, start, end, curve, same) in file.all("EDGE_CURVE"):
        _, in_space, pcurves, _ = file.get(curve, "SURFACE_CURVE")
        space = Curve(file, in_space)
        t = np.concatenate([np.linspace(a, b, 12) for a, b in zip(space.spans, space.spans[1:])])
        p, _ = space.at(t)
        for vertex, q in ((start, p[0]), (end, p[-1])):
            if np.linalg.norm(file.point(file.get(vertex, "VERTEX_POINT")[1]) - q) > uncertainty:
                raise Fault(f"#{reference[1]} does not end at its vertex")
        on_surface = {}
        for pcurve in pcurves:
            _, on, representation = file.get(pcurve, "PCURVE")
            trim = Curve(file, file.get(representation, "DEFINITIONAL_REPRESENTATION")[1][0])
            if (trim.knots[0], trim.knots[-1]) != (space.knots[0], space.knots[-1]):
                raise Fault(f"#{pcurve[1]} has parameters of its own")
            uv, _ = trim.at(t)
            if np.linalg.norm(surfaces[on].at(uv[:, 0], uv[:, 1])[0] - p, axis=1).max() > uncertainty:
                raise Fault(f"#{pcurve[1]} is not the curve in space")
            on_surface[on] = trim
        if len(on_surface) != 2 or same != ".T.":
            raise Fault(f"#{reference[1]} does not lie on two surfaces")
        edges[reference] = (start, end, on_surface)

    solids = [file.get(s, "MANIFOLD_SOLID_BREP")[1] for s, _ in file.all("MANIFOLD_SOLID_BREP")]
    shells = file.all("CLOSED_SHELL")
    if not shells or sorted(solids) != sorted(s for s, _ in shells):
        raise Fault("the solids are not the closed shells")
    uses = collections.Counter()
    for _, (_, faces) in shells:
        for face in faces:
            _, bounds, on, same = file.get(face, "ADVANCED_FACE")
            places, steps_v = [], []
            for k, bound in enumerate(bounds):
                entity = "FACE_OUTER_BOUND" if k == 0 else "FACE_BOUND"
                _, loop, forward = file.get(bound, entity)
                steps = []
                for oriented in file.get(loop, "EDGE_LOOP")[1]:
                    *_, edge, sense = file.get(oriented, "ORIENTED_EDGE")
                    sense = sense == ".T."
                    uses[edge, sense] += 1
                    start, end, on_surface = edges[edge]
                    steps.append((start, end) if sense else (end, start))
                    trim = on_surface[on]
                    for a, b in zip(trim.spans, trim.spans[1:]):
                        half = 0.5 * (b - a) / PARTS
                        t = (a + half * (2 * np.arange(PARTS)[:, None] + 1 + NODES)).ravel()
                        uv, d = trim.at(t)
                        places.append(uv)
                        steps_v.append(np.tile(WEIGHTS, PARTS) * half * d[:, 1] * (1 if sense else -1))
                if any(a[1] != b[0] for a, b in zip(steps, steps[1:] + steps[:1])) or forward != ".T.":
                    raise Fault(f"#{loop[1]} is no loop")
            u, v = np.concatenate(places).T
            flux = surfaces[on].flux(u, v) @ np.concatenate(steps_v)
            volume += flux if same == ".T." else -flux
    for edge in edges:
        if uses[edge, True] != 1 or uses[edge, False] != 1:
            raise Fault(f"#{edge[1]} is not used once each way")
    return volume


def fails(text):
    try:
        return not np.isfinite(judged(text))
    except (Fault, KeyError):
        return True


def main():
    program, folder, *scenes = sys.argv[1:]
    pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    for scene in scenes:
        path = pathlib.Path(folder) / (pathlib.Path(scene).stem + ".step")
        subprocess.run([program, "compute", scene, "-o", str(path)], check=True)
        table = subprocess.run([program, "measure", scene], check=True, capture_output=True, text=True).stdout
        expected = float(next(csv.DictReader(table.splitlines(), delimiter="\t"))["volume"])
        text = path.read_text()
        try:
            volume = judged(text)
        except Fault as fault:
            sys.exit(f"{scene}: {fault}")
        print(f"{scene}: {volume!r}, off by {abs(volume - expected) / expected:.1e}")
        if not abs(volume - expected) <= 1e-6 * expected:
            sys.exit(f"{scene}: the volume is {volume}, not {expected}")
    # The cells of a diagram are a solid each, and fill their box.
    scene, path = pathlib.Path(scenes[0]).with_name("ball_tube_plane.json"), pathlib.Path(folder) / "diagram.step"
    told = subprocess.run([program, "diagram", str(scene), "-o", str(path)], check=True, capture_output=True, text=True)
    row = next(csv.DictReader(told.stdout.splitlines(), delimiter="\t"))
    volume, expected = judged(path.read_text()), float(row["volume"])
    print(f"{scene}: {volume!r}, off by {abs(volume - expected) / expected:.1e}")
    if not abs(volume - expected) <= 1e-6 * expected:
        sys.exit(f"{scene}: the cells' volume is {volume}, not {expected}")
    # What is judged last but that, damaged.
    sense = re.search(r"ORIENTED_EDGE\('',\*,\*,#\d+,\.T\.\)", text)[0]
    pole = re.search(r"(CARTESIAN_POINT\('',\()(-?\d+\.\d*)", text)
    vertex = re.search(r"EDGE_CURVE\('',#(\d+),#(\d+)", text)
    for damaged in (text.replace(sense, sense.replace(".T.", ".F."), 1),
                    text.replace(pole[0], f"{pole[1]}{float(pole[2]) + 0.01!r}", 1),
                    text.replace(vertex[0], f"EDGE_CURVE('',#{vertex[2]},#{vertex[1]}", 1),
                    re.sub(r"CLOSED_SHELL\('',\(#\d+,", "CLOSED_SHELL('',(", text, count=1)):
        if damaged == text or not fails(damaged):
            sys.exit("a damaged file passed")


if __name__ == "__main__":
    main()
