#!/usr/bin/env python3
"""Runs bench_radial and writes its measurements as bench/results/radial.csv.

    bench/record_radial.py build/release/bench/bench_radial --molecules FOLDER

FOLDER holds 1CRN.xyzr and 1AKI.xyzr; without it atoms are left out. Seconds are CPU time: the median and 90 %
quantile over the cells of a family of each one's least; `first` the median of each one's first call; stages are
wall-clock time, medians. `unmeasured` is the median without lengths, areas and volumes, `patches` among the stages the one with them. Targets are for exact cells
with patches: met where `unmeasured_ratio`, unmeasured / target, is at most 1, and met with measures, too, where
`target_ratio`, seconds / target, is. `speedup` is the paper's own time / ours. Decisions are those of one call for each
cell.

The commit is that of the source tree this script lies in ("+" when files differ from it): build there before
recording. Exit status 1: the bench failed, or found a wrong result.
"""
import argparse
import csv
import math
import pathlib
import statistics

import record

# Seconds that a family's median may take.
TARGETS = {"atom/1CRN": 60e-6, "atom/1AKI": 60e-6, "around/1000": 5e-3, "tubes": 0.1, "scene/figure8": 0.5e-3,
           "scene/figure9": 0.5e-3, "scene/figure10": 5e-3}
DECISIONS = ("double", "interval", "exact", "multiprecision", "assumed")
COLUMNS = ("scene", "n", "cells", "seconds", "seconds_p90", "first", "seconds_bisectors", "seconds_envelope", "seconds_patches",
           "unmeasured", "target", "target_ratio", "unmeasured_ratio", "paper_seconds", "speedup", "V", "E", "F", *DECISIONS, "warnings", "compiler",
           "machine", "commit")


def row(name, b):
    seconds, unmeasured = b["median_us"] * 1e-6, b["unmeasured_us"] * 1e-6
    target, paper = TARGETS.get(name), b["paper_seconds"]
    return {
        "scene": name, "n": round(b["n"]), "cells": round(b["cells"]), "seconds": f"{seconds:.4g}",
        "seconds_p90": f"{b['p90_us'] * 1e-6:.4g}", "first": f"{b['first_us'] * 1e-6:.4g}",
        **{f"seconds_{stage}": f"{b[stage + '_us'] * 1e-6:.4g}" for stage in ("bisectors", "envelope", "patches")},
        "unmeasured": f"{unmeasured:.4g}",
        **({"target": f"{target:g}", "target_ratio": f"{seconds / target:.3g}",
            "unmeasured_ratio": f"{unmeasured / target:.3g}"} if target else {}),
        **({"paper_seconds": f"{paper:g}", "speedup": f"{paper / seconds:.4g}"} if paper else {}),
        **{k: f"{b[k]:.1f}" for k in ("V", "E", "F")}, **{k: round(b[k]) for k in (*DECISIONS, "warnings")},
    }


def exponent(rows):
    """p of seconds = c n^p, least squares of the logarithms."""
    return statistics.linear_regression([math.log(r["n"]) for r in rows],
                                        [math.log(float(r["seconds"])) for r in rows]).slope


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="bench_radial, built in Release")
    parser.add_argument("--molecules", type=pathlib.Path, help="folder of 1CRN.xyzr and 1AKI.xyzr")
    parser.add_argument("--max-n", type=int, default=100000, help="most balls around one (default 100000)")
    parser.add_argument("--min-time", type=float, default=1, help="seconds of each measurement (default 1)")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=record.SOURCE / "bench/results/radial.csv")
    options = parser.parse_args()
    arguments = [f"--max_n={options.max_n}", f"--benchmark_min_time={options.min_time}"]
    if options.molecules:
        arguments.append(f"--molecules={options.molecules}")
    report = record.report_of(options.program, arguments)
    origin = {"compiler": report["context"]["compiler"], "machine": record.machine(), "commit": record.commit()}
    rows = [{**row(b["run_name"], b), **origin} for b in report["benchmarks"]]
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    around = [r for r in rows if r["scene"].startswith("around/")]
    print(f"{options.output}: balls around one take n^{exponent(around):.2f}")


if __name__ == "__main__":
    main()
