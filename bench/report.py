#!/usr/bin/env python3
"""Writes what bench/results holds where people read it: the tables of README.md and docs/performance.md between their
marks "<!-- measured: NAME -->" and "<!-- end -->", and docs/pictures/figure11.svg.

    bench/report.py [--check]

What was not measured is left out. With --check nothing is written: the exit status is 1 if anything would change.
"""
import argparse
import csv
import math
import pathlib
import re
import sys

import record

RESULTS = record.SOURCE / "bench/results"
FIGURE = record.SOURCE / "docs/pictures/figure11.svg"


def read(name):
    with open(RESULTS / name, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def by_scene(name):
    return {r["scene"]: r for r in read(name)}


def digits(x, n=3):
    """n significant digits, without an exponent, thousands with commas."""
    if x == 0:
        return "0"
    places = n - 1 - math.floor(math.log10(abs(x)))
    return f"{round(x, places):,.{max(0, places)}f}"


def time(seconds):
    seconds = float(seconds)
    for unit, size in (("s", 1), ("ms", 1e-3), ("µs", 0)):
        if seconds >= 0.9995 * size:
            return f"{digits(seconds / (size or 1e-6))} {unit}"


def ratio(r):
    return digits(float(r["paper_seconds"]) / float(r["seconds"]), 2) if r.get("paper_seconds") else ""


def large(n):
    n = int(n)
    return f"{n:,}" if n < 1e5 else f"{digits(n / 1e3)} k" if n < 1e6 else f"{digits(n / 1e6)} M"


def table(head, align, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "|".join("--:" if a == "r" else "---" for a in align) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


# ---- The tables -----------------------------------------------------------------------------------------------

def summary():
    """One row for each kind of scene, for who reads nothing else."""
    cells, around = by_scene("mixed.csv"), by_scene("radial.csv")
    spheres = {(r["scene"], int(r["n"])): r for r in read("envelope.csv")}
    cgals = {int(r["n"]): r for r in read("cgal.csv")}
    rows = [(what, time(r["paper_seconds"]), "", time(r["seconds"])) for what, r in (
        ("a plane under 24 balls", cells.get("table3_24")), ("a plane under three cylinders", cells.get("figure6")),
        ("a ball among six balls", around.get("scene/figure8"))) if r]
    if 10_000 in cgals:
        r = cgals[10_000]
        rows.append(("10,000 balls over a plane, the envelope alone", "", time(float(r["peer_ms"]) / 1e3),
                     time(float(r["vcell_ms"]) / 1e3)))
    if ("random", 1_000_000) in spheres:
        rows.append(("1,000,000 of them", "", "", time(spheres["random", 1_000_000]["seconds"])))
    if "atom/1CRN" in around:
        rows.append(("an atom of a protein of 327", "", "", time(around["atom/1CRN"]["seconds"])))
    return table(("", "the paper's (2007)", "CGAL 5.5", "vcell"), "lrrr", rows)


def cgal():
    return table(("spheres", "vertices, edges, faces", "CGAL", "vcell", "ratio"), "rrrrr",
                 [(f"{int(r['n']):,}", f"{r['V']}, {r['E']}, {r['F']}", time(float(r["peer_ms"]) / 1e3),
                   time(float(r["vcell_ms"]) / 1e3), digits(float(r["ratio"]), 2)) for r in read("cgal.csv")])


def envelope():
    wanted = {("random", n) for n in (1000, 10_000, 100_000, 1_000_000)} | {("lattice", 10_000), ("lattice", 1_000_000)}
    rows = [r for r in read("envelope.csv") if (r["scene"], int(r["n"])) in wanted]
    text = table(("scene", "n", "time", "peak memory", "signs by double, interval, exact"), "lrrrr",
                 [(r["scene"], f"{int(r['n']):,}", time(r["seconds"]), f"{digits(float(r['peak_MB']))} MB",
                   ", ".join(large(r[k]) for k in ("double", "interval", "exact"))) for r in rows])
    growth = [float(r["t2n_over_tn"]) for r in read("envelope.csv") if r["t2n_over_tn"] and int(r["n"]) >= 20_000]
    if growth:
        text += (f"\n\nFrom 10,000 spheres upwards doubling n multiplies the time by {min(growth):.1f} to "
                 f"{max(growth):.1f}.")
    assumed = sum(int(r["assumed"]) for r in read("envelope.csv"))
    return text + (" Nothing is assumed." if assumed == 0 else f" {assumed} coincidences are assumed.")


def table3_rows():
    return sorted((r for r in read("mixed.csv") if r["scene"].startswith("table3_")), key=lambda r: int(r["n"]))


def fit(rows, key):
    """c of seconds = c n log2 n, least squares of the relative errors, and the largest of those."""
    ratios = [float(r[key]) / (int(r["n"]) * math.log2(int(r["n"]))) for r in rows]
    c = sum(1 / x for x in ratios) / sum(1 / x**2 for x in ratios)
    return c, max(abs(x / c - 1) for x in ratios)


def table3():
    rows = table3_rows()
    if not rows:
        return "Not measured."
    text = table(("n", *(r["n"] for r in rows)), "l" + "r" * len(rows), [
        ("[HE]", *(f"{float(r['paper_seconds']):.2f} s" for r in rows)),
        ("vcell", *(time(r["seconds"]) for r in rows)),
        ("ratio", *(ratio(r) for r in rows)),
    ])
    (ours, error), (theirs, _) = fit(rows, "seconds"), fit(rows, "paper_seconds")
    return text + (f"\n\nThe fitted curves are {digits(1e6 * ours)} µs · n log₂ n, within {100 * error:.0f} %, and "
                   f"{digits(1e3 * theirs)} ms · n log₂ n (the paper says 0.05 s · n log n, to base ten).")


def mixed():
    cells = by_scene("mixed.csv")
    rows = []
    for scene, what in (("figure5", "Fig. 5: plane among a plane, a cylinder, two spheres (`figure5.json`)"),
                        ("figure6", "Fig. 6: plane among three cylinders (`figure6.json`)"),
                        ("pile_50", "40 balls and 10 rods (`pile_50.json`)"),
                        ("pile_500", "400 balls and 100 rods (`pile_500.json`)")):
        if scene not in cells:
            continue
        r = cells[scene]
        rows.append((what, f"{r['V']}, {r['E']}, {r['F']}",
                     time(r["paper_seconds"]) if r["paper_seconds"] else "", time(r["seconds"]), ratio(r)))
    return table(("scene", "vertices, edges, faces", "[HE]", "vcell", "ratio"), "lrrrr", rows)


def parts():
    cells, systems = by_scene("mixed.csv"), {(r["family"], r["box"]): r for r in read("solver.csv")}
    rows = []
    for family, what in (("psc", "a trisector traced, proved and fitted, at 1e-4 / 1e-7 of the diagonal: plane, sphere, "
                                 "cylinder"), ("pcc", "plane, cylinder, cylinder")):
        rows.append((what, *(time(cells[f"trisector/{family}/{t}"]["seconds"]) for t in ("1e-4", "1e-7"))))
    first = "all points equally far from four objects, with proofs, in the scene's box / around an arc: "
    systems_of = {"four_spheres": "four spheres", "plane_three_spheres": "plane, three spheres",
                  "plane_two_spheres_cylinder": "plane, two spheres, cylinder",
                  "plane_sphere_two_cylinders": "plane, sphere, two cylinders",
                  "plane_three_cylinders": "plane, three cylinders", "four_cylinders": "four cylinders"}
    for family in systems_of:
        rows.append((first + systems_of[family],
                     *(time(systems[family, box]["seconds"]) for box in ("scene", "arc"))))
        first = ""
    return table(("median over random input", "", ""), "lrr", rows)


def radial():
    cells = by_scene("radial.csv")
    rows = []
    for scene, what in (
            ("atom/1CRN", "an atom of crambin (1CRN) among all {cells}, median; {n} of them are looked at"),
            ("atom/1AKI", "an atom of lysozyme (1AKI) among all {cells}, median; {n} of them are looked at"),
            ("around/1000", "1,000 balls on a shell around one"),
            ("around/100000", "100,000 balls on a shell around one"),
            ("scene/figure8", "Fig. 8: ball among six balls (`figure8.json`)"),
            ("scene/figure9", "Fig. 9: ball among two planes and two balls (`figure9.json`)"),
            ("scene/figure10", "Fig. 10: tube among two planes and a ball (`figure10.json`)"),
            ("tubes", "20 skew tubes around a tube, median of {cells}")):
        if scene not in cells:
            continue
        r = cells[scene]
        rows.append((what.format(cells=f"{int(r['cells']):,}", n=f"{float(r['n']):.0f}"),
                     ", ".join(f"{float(r[k]):.0f}" for k in "VEF"),
                     time(r["paper_seconds"]) if r["paper_seconds"] else "", time(r["first"]) if r.get("first") else "", time(r["seconds"]),
                     time(r["unmeasured"]), ratio(r)))
    return table(("cell", "vertices, edges, faces", "[HE]", "first call", "again", "again, without measures", "ratio"),
                 "lrrrrrr", rows)


def growth():
    """Of each family over each base: the seconds of 1,000 objects, and the exponent."""
    bases = {"plane": "over a plane", "tilted_plane": "over a tilted plane", "ball": "around a ball",
             "tube": "around a tube"}
    families = {"balls": "balls", "balls_walls": "balls and planes", "balls_rod": "balls and one rod",
                "balls_walls_rod": "balls, planes and one rod", "balls_rods": "balls and rods",
                "shell": "balls and rods that touch one surface parallel to the base",
                "parallel_tubes": "parallel tubes", "skew_tubes": "skew tubes"}
    cells = {(r["base"], r["family"], int(r["n"])): r for r in read("growth.csv")}
    rows = []
    for family, what in families.items():
        row = [what]
        for base in bases:
            r = cells.get((base, family, 1000))
            row.append(f"{time(r['seconds'])}, n^{r['exponent']}" if r and r["seconds"] else "")
        rows.append(row)
    return table(("1,000 objects", *bases.values()), "lrrrr", rows)


def diagram():
    cells = by_scene("diagram.csv")
    rows = []
    for scene, what in (
            ("molecule/1CRN", "1CRN in a box with 5 Å of room"),
            ("molecule/1AKI", "1AKI, likewise"),
            ("molecule/4HHB", "4HHB, likewise"),
            ("molecule/4YVS", "4YVS, likewise"),
            ("random/10000", "random points in a cube"),
            ("packing/10000", "disjoint balls of radii up to 5:1 in a box that repeats"),
            ("tubes/100", "disjoint tubes that run through a cube in all directions"),
            ("lattice/bcc", "body-centred cubic lattice"),
            ("lattice/fcc", "face-centred cubic lattice, where six balls tie in a vertex"),
            ("jittered/fcc", "the same, jittered")):
        if scene in cells:
            r = cells[scene]
            rows.append((what, large(r["n"]), time(r["seconds"]), time(1e-6 * float(r["us_per_object"])),
                         f"{float(r['contacts']) / float(r['n']):.1f}", r["volume_error"]))
    return table(("scene", "objects", "all cells", "an object", "contacts an object", "bound on the volumes' sum, parts of the box"),
                 "lrrrrr", rows)


PAGES = {"README.md": (summary,), "docs/performance.md": (cgal, envelope, table3, mixed, parts, radial, growth, diagram)}


# ---- Fig. 11 ---------------------------------------------------------------------------------------------------

def figure11():
    """Time against n, logarithmic: both series and their fits."""
    rows = table3_rows()
    width, height, left, bottom, top, right = 560, 380, 70, 50, 20, 20
    n_max = 26
    series = (("[HE]", "paper_seconds", "#ee8866"), ("vcell", "seconds", "#4477aa"))
    values = [float(r[key]) for _, key, _ in series for r in rows]
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))

    def x(n):
        return left + (width - left - right) * n / n_max

    def y(seconds):
        return height - bottom - (height - bottom - top) * (math.log10(seconds) - low) / (high - low)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
           'font-family="sans-serif" font-size="13">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    for power in range(low, high + 1):
        name = {1: "10 s", 0: "1 s", -1: "0.1 s", -2: "10 ms", -3: "1 ms", -4: "0.1 ms", -5: "10 µs", -6: "1 µs"}.get(
            power, f"1e{power} s")
        at = y(10.0**power)
        out.append(f'<path d="M{left} {at:.1f}H{width - right}" stroke="#dddddd"/>'
                   f'<text x="{left - 8}" y="{at + 4:.1f}" text-anchor="end">{name}</text>')
    for n in range(0, n_max + 1, 4):
        out.append(f'<path d="M{x(n):.1f} {height - bottom}v5" stroke="black"/>'
                   f'<text x="{x(n):.1f}" y="{height - bottom + 20}" text-anchor="middle">{n}</text>')
    out.append(f'<path d="M{left} {top}V{height - bottom}H{width - right}" fill="none" stroke="black"/>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 10}" text-anchor="middle">'
               'spheres over a plane</text>')
    for name, key, colour in series:
        c, _ = fit(rows, key)
        ns = [3 + k / 4 for k in range(4 * (n_max - 3) + 1)]
        path = " ".join(f"{x(n):.1f} {y(c * n * math.log2(n)):.1f}" for n in ns)
        out.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        for r in rows:
            out.append(f'<circle cx="{x(int(r["n"])):.1f}" cy="{y(float(r[key])):.1f}" r="3.5" fill="{colour}">'
                       f'<title>{r["n"]}: {time(r[key])}</title></circle>')
        end = rows[-1]
        out.append(f'<text x="{x(int(end["n"])):.1f}" y="{y(float(end[key])) - 14:.1f}" text-anchor="end" '
                   f'fill="{colour}">{name}: {time(c)} · n log₂ n</text>')
    return "\n".join(out) + "\n</svg>\n"


def filled(page, blocks):
    """The page with these blocks between its marks."""
    by_name, names = {f.__name__: f for f in blocks}, []

    def block(match):
        names.append(match[1])
        if match[1] not in by_name:
            sys.exit(f"{page} has a mark for {match[1]}, which is none of {list(by_name)}")
        return f"<!-- measured: {match[1]} -->\n{by_name[match[1]]()}\n<!-- end -->"

    text = (record.SOURCE / page).read_text(encoding="utf-8")
    text = re.sub(r"<!-- measured: (\w+) -->\n.*?<!-- end -->", block, text, flags=re.S)
    if sorted(names) != sorted(by_name):
        sys.exit(f"{page} has marks for {names}, not for each of {list(by_name)}")
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    contents = {record.SOURCE / page: filled(page, blocks) for page, blocks in PAGES.items()}
    if table3_rows():
        contents[FIGURE] = figure11()
    changed = []
    for path, content in contents.items():
        if not path.exists() or path.read_text(encoding="utf-8") != content:
            changed.append(path.name)
            if not options.check:
                path.write_text(content, encoding="utf-8")
    if options.check and changed:
        sys.exit(f"{', '.join(changed)}: not what bench/results holds; run bench/report.py")


if __name__ == "__main__":
    main()
