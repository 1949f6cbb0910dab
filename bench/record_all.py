#!/usr/bin/env python3
"""Measures everything and writes it where people read it, on a machine that has nothing else to do:

    cmake --preset release && cmake --build --preset release
    bench/record_all.py build/release --molecules FOLDER [--cgal PEER DATA...]

FOLDER holds 1CRN.xyzr, 1AKI.xyzr, 4HHB.xyzr and 4YVS.xyzr, without it atoms and whole diagrams keep their old figures; PEER and DATA are those of
compare_cgal.py, without them that table keeps its old figures. Writes bench/results, and from there README.md, docs/performance.md and
docs/pictures/figure11.svg (report.py) and docs/tables.md (examples/tables). About an hour; --quick takes a
few minutes and its figures are for a look only.
"""
import argparse
import csv
import pathlib
import subprocess
import sys

import record

BENCH = record.SOURCE / "bench"
RADIAL = BENCH / "results/radial.csv"


def run(script, *arguments):
    status = subprocess.run([sys.executable, BENCH / script, *map(str, arguments)], check=False).returncode
    if status != 0:
        sys.exit(f"record_all.py: {script} failed, as told above; what comes after it is not measured")


def keep_atoms(old):
    """Rows that were not measured stay what they were, with their own commit."""
    with open(RADIAL, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        rows, columns = list(reader), reader.fieldnames
    rows = [r for r in old if r["scene"].startswith("atom/")] + rows
    with open(RADIAL, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n", extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path, help="the built tree of the preset release")
    parser.add_argument("--molecules", type=pathlib.Path)
    parser.add_argument("--cgal", nargs="+", metavar=("PEER", "DATA"))
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    bench = options.build / "bench"
    quick = options.quick
    run("record.py", bench / "bench_envelope", "--max-n", 10_000 if quick else 1_000_000,
        *(["--repetitions", 2, "--min-time", 0.05] if quick else []))
    run("record_mixed.py", bench, *(["--max-n", 100, "--repetitions", 2, "--min-time", 0.02] if quick else []))
    with open(RADIAL, newline="", encoding="utf-8") as file:
        old = list(csv.DictReader(file))
    run("record_radial.py", bench / "bench_radial", *(["--max-n", 1000, "--min-time", 0.02] if quick else []),
        *(["--molecules", options.molecules] if options.molecules else []))
    if not options.molecules:
        keep_atoms(old)
    run("record_growth.py", bench / "bench_growth", *(["--max-n", 1000, "--seeds", 3] if quick else []))
    if options.molecules:
        run("record_diagram.py", bench / "bench_diagram", "--molecules", options.molecules,
            *(["--repetitions", 1] if quick else []))
    if options.cgal:
        run("compare_cgal.py", *options.cgal, "--ours", bench / "envelope_of_file")
    tables = subprocess.run([options.build / "examples/tables", RADIAL], check=True, capture_output=True)
    (record.SOURCE / "docs/tables.md").write_bytes(tables.stdout)
    run("report.py")


if __name__ == "__main__":
    main()
