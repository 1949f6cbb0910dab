#!/usr/bin/env python3
"""Runs bench_growth and writes its measurements as bench/results/growth.csv.

    bench/record_growth.py build/release/bench/bench_growth

A row for each base, family of scenes and number n of objects: CPU seconds of voronoi_cell(), median and largest over the
seeds, their ratio, and the exponent p of seconds = c n^p, least squares of the logarithms over the family's sizes from 100
on; V, E, F and the signs decided are means. Scenes that are illegal or could not be decided are counted, and not timed.
Sizes that would take too long are skipped, as bench_growth says.

The commit is that of the source tree this script lies in ("+" when files differ from it): build there before
recording. Exit status 1: the bench failed.
"""
import argparse
import csv
import math
import pathlib
import statistics
import subprocess
import sys

import record

COUNTS = ("V", "E", "F", "double", "interval", "exact", "multiprecision", "assumed")
COLUMNS = ("base", "family", "n", "scenes", "illegal", "undecided", "seconds", "seconds_max", "max_ratio", "exponent",
           *COUNTS, "machine", "commit")
LEAST_N = 100  # below it the cell's fixed cost hides the growth


def row(base, family, n, scenes):
    refused = [s["refused"].split(":")[0] for s in scenes if s["refused"]]
    timed = [s for s in scenes if not s["refused"]]
    out = {"base": base, "family": family, "n": n, "scenes": len(scenes), "illegal": refused.count("illegal"),
           "undecided": refused.count("undecided")}
    if timed:
        seconds = [float(s["seconds"]) for s in timed]
        median, largest = statistics.median(seconds), max(seconds)
        out |= {"seconds": f"{median:.4g}", "seconds_max": f"{largest:.4g}", "max_ratio": f"{largest / median:.2f}",
                **{c: f"{statistics.fmean(int(s[c]) for s in timed):.1f}" for c in COUNTS}}
    return out


def exponent(rows):
    """None from fewer than two sizes."""
    timed = [r for r in rows if r["n"] >= LEAST_N and "seconds" in r]
    if len(timed) < 2:
        return None
    return statistics.linear_regression([math.log(r["n"]) for r in timed],
                                        [math.log(float(r["seconds"])) for r in timed]).slope


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="bench_growth, built in Release")
    parser.add_argument("--max-n", type=int, default=10000, help="most objects (default 10000)")
    parser.add_argument("--seeds", type=int, default=20, help="scenes of each size (default 20), fewer where they take long")
    parser.add_argument("--most-seconds", type=float, default=60, help="that a family's size may take (default 60)")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=record.SOURCE / "bench/results/growth.csv")
    options = parser.parse_args()
    run = subprocess.run([options.program, f"--max_n={options.max_n}", f"--seeds={options.seeds}",
                          f"--most_seconds={options.most_seconds}"], check=False, stdout=subprocess.PIPE, text=True)
    if run.returncode != 0:
        sys.exit(f"record_growth.py: {options.program} failed")
    families = {}
    for scene in csv.DictReader(run.stdout.splitlines()):
        families.setdefault((scene["base"], scene["family"]), {}).setdefault(int(scene["n"]), []).append(scene)
    origin = {"machine": record.machine(), "commit": record.commit()}
    rows, steepest, widest = [], (0, ""), (0, "")
    for (base, family), sizes in families.items():
        of_family = [row(base, family, n, scenes) for n, scenes in sizes.items()]
        p = exponent(of_family)
        for r in of_family:
            if p is not None:
                r["exponent"] = f"{p:.2f}"
                steepest = max(steepest, (p, f"{base}/{family}"))
            if "max_ratio" in r:
                widest = max(widest, (float(r["max_ratio"]), f"{base}/{family}/{r['n']}"))
        rows += [{**r, **origin} for r in of_family]
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    refused = sum(r["illegal"] + r["undecided"] for r in rows)
    print(f"{options.output}: {steepest[1]} grows most, n^{steepest[0]:.2f}; {widest[1]} differs most, its slowest scene "
          f"takes {widest[0]:.1f} times the median; {refused} scenes were refused")


if __name__ == "__main__":
    main()
