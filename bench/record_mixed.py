#!/usr/bin/env python3
"""Runs bench_mixed and bench_solver and writes their measurements as CSV.

    bench/record_mixed.py build/release/bench

writes bench/results/mixed.csv (cells of scenes with cylinders and of Table 3's; trisectors) and
bench/results/solver.csv (vertex systems); with --table3 only the former's rows of Table 3, in their place. Seconds are CPU time: of cells the median and least of the repetitions; of trisectors the
median, 90 % quantile and largest over random pairs, as bench_mixed says. Wall-clock times are those of a
cell's stages, least of the repetitions, and of vertex systems, which take microseconds: the least of all runs
of a system, then the quantiles over the systems. A target is met where `target_ratio`, seconds / target, is
at most 1; `speedup` is the paper's own time / ours. Decisions are those of one call (trisectors: of one call
for each pair).

The commit is that of the source tree this script lies in ("+" when files differ from it): build there before
recording. Exit status 1: a bench failed, or found a wrong result.
"""
import argparse
import csv
import math
import pathlib
import statistics

import record

# Seconds that a scene or a family's median may take.
CELL_TARGETS = {"figure5": 2e-3, "figure6": 10e-3, "pile_500": 2.0}
TRISECTOR_TARGETS = {"1e-4": 0.6e-3, "1e-7": 1.5e-3}
SOLVER_TARGETS = {"four_spheres": 10e-6, "plane_three_spheres": 10e-6, "plane_two_spheres_cylinder": 60e-6,
                  "plane_sphere_two_cylinders": 60e-6, "plane_three_cylinders": 60e-6,
                  "four_cylinders": 250e-6}
ARC_TARGET = 3e-6
DECISIONS = ("double", "interval", "exact", "multiprecision", "assumed")
ORIGIN = ("compiler", "machine", "commit")
MIXED = ("scene", "n", "seconds", "seconds_min", "seconds_p90", "seconds_max", "seconds_bisectors",
         "seconds_envelope", "seconds_patches", "target", "target_ratio", "paper_seconds", "speedup", "V", "E", "F",
         "spans", *DECISIONS, "warnings", *ORIGIN)
SOLVER = ("family", "box", "systems", "seconds", "seconds_p90", "seconds_mean", "target", "target_ratio",
          "roots", "steps", "undecided", "wide", *ORIGIN)


def measurements(report):
    """The repetitions of each bench, by its name."""
    runs = {}
    for b in report["benchmarks"]:
        if b["run_type"] == "iteration":
            runs.setdefault(b["run_name"], []).append(b)
    return runs


def against(target, seconds):
    return {"target": f"{target:g}", "target_ratio": f"{seconds / target:.3g}"} if target else {}


def cell_row(name, runs):
    scale = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
    times = [b["cpu_time"] * scale[b["time_unit"]] for b in runs]
    seconds, b = statistics.median(times), runs[0]
    paper = b["paper_seconds"]
    return {
        "scene": name, "n": round(b["n"]), "seconds": f"{seconds:.4g}", "seconds_min": f"{min(times):.4g}",
        **{stage: f"{min(r[stage] for r in runs):.4g}"
           for stage in ("seconds_bisectors", "seconds_envelope", "seconds_patches")},
        **against(CELL_TARGETS.get(name), seconds),
        **({"paper_seconds": f"{paper:g}", "speedup": f"{paper / seconds:.4g}"} if paper else {}),
        **{k: round(b[k]) for k in ("V", "E", "F", *DECISIONS, "warnings")},
    }


def trisector_row(name, runs):
    def us(key):
        return statistics.median(b[key] for b in runs) * 1e-6

    seconds, b = us("median_us"), runs[0]
    return {"scene": name, "n": round(b["pairs"]), "seconds": f"{seconds:.4g}",
            "seconds_p90": f"{us('p90_us'):.4g}",
            "seconds_max": f"{us('max_us'):.4g}", **against(TRISECTOR_TARGETS[name.split("/")[-1]], seconds),
            "spans": f"{b['spans']:.2f}", **{k: round(b[k]) for k in DECISIONS}}


def solver_row(name, runs):
    def us(key):
        return statistics.median(b[key] for b in runs) * 1e-6

    family, box = name.split("/")
    seconds, b = us("median_us"), runs[0]
    target = ARC_TARGET if box == "arc" else SOLVER_TARGETS.get(family)
    return {"family": family, "box": box, "systems": round(b["systems"]), "seconds": f"{seconds:.4g}",
            "seconds_p90": f"{us('p90_us'):.4g}", "seconds_mean": f"{us('mean_us'):.4g}",
            **against(target, seconds), "roots": f"{b['roots']:.3f}", "steps": f"{b['steps']:.2f}",
            "undecided": round(b["undecided"]), "wide": round(b["wide"])}


def write(path, columns, rows):
    with open(path, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def exponent(rows):
    """p of seconds = c n^p, least squares of the logarithms."""
    x = [math.log(r["n"]) for r in rows]
    y = [math.log(float(r["seconds"])) for r in rows]
    return statistics.linear_regression(x, y).slope


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="of the built bench_mixed and bench_solver")
    parser.add_argument("--max-n", type=int, default=2000, help="largest pile (default 2000)")
    parser.add_argument("--repetitions", type=int, default=5, help="of each measurement (default 5)")
    parser.add_argument("--min-time", type=float, default=0.2, help="seconds of a repetition (default 0.2)")
    parser.add_argument("--table3", action="store_true", help="measure the scenes of Table 3 alone")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=record.SOURCE / "bench/results")
    options = parser.parse_args()
    common = [f"--benchmark_repetitions={options.repetitions}",
              f"--benchmark_min_time={options.min_time}"]
    options.output.mkdir(parents=True, exist_ok=True)

    only = ["--benchmark_filter=^scene/table3_"] if options.table3 else []
    mixed = record.report_of(options.folder / "bench_mixed", [f"--max_n={options.max_n}", *common, *only])
    origin = {"compiler": mixed["context"]["compiler"], "machine": record.machine(), "commit": record.commit()}
    rows = []
    for name, runs in measurements(mixed).items():
        if name.startswith("trisector/"):
            rows.append({**trisector_row(name, runs), **origin})
        else:
            rows.append({**cell_row(name.removeprefix("scene/"), runs), **origin})
    if options.table3:
        new = {r["scene"] for r in rows}
        with open(options.output / "mixed.csv", newline="", encoding="utf-8") as old:
            rows = [r for r in csv.DictReader(old) if r["scene"] not in new] + rows
        write(options.output / "mixed.csv", MIXED, rows)
        return
    write(options.output / "mixed.csv", MIXED, rows)
    piles = [r for r in rows if r["scene"].startswith("pile/")]
    print(f"{options.output / 'mixed.csv'}: piles take n^{exponent(piles):.2f}")

    solver = measurements(record.report_of(options.folder / "bench_solver", common))
    write(options.output / "solver.csv", SOLVER,
          [{**solver_row(name, runs), **origin} for name, runs in solver.items()])
    print(options.output / "solver.csv")


if __name__ == "__main__":
    main()
