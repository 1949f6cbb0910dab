#!/usr/bin/env python3
"""Runs bench_diagram and writes its measurements as bench/results/diagram.csv.

    bench/record_diagram.py build/release/bench/bench_diagram --molecules FOLDER

FOLDER holds 1CRN.xyzr, 1AKI.xyzr, 4HHB.xyzr and 4YVS.xyzr; without it molecules are left out. Seconds are CPU time of one
thread: search, proofs that the cells are complete, areas and volumes of all of them, the least of the repetitions.
`volume_error` is the bound on the sum of the volumes, against the box's, which the bench finds within it; `candidates` the
objects that a cell was computed among. Targets are microseconds an object.

The commit is that of the source tree this script lies in ("+" when files differ from it): build there before
recording. Exit status 1: the bench failed, or found a diagram that does not fill its box.
"""
import argparse
import csv
import pathlib

import record

TARGETS = {"molecule/4YVS": 40, "packing/10000": 80, "tubes/100": 600000}
COLUMNS = ("scene", "n", "seconds", "us_per_object", "target", "target_ratio", "contacts", "candidates", "volume_error", "compiler",
           "machine", "commit")


def rows_of(report):
    """One row a scene, in the bench's order: its least repetition."""
    unit = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
    least = {}
    for b in report["benchmarks"]:
        name = b["run_name"].removesuffix("/real_time")
        if b["run_type"] == "iteration" and b["cpu_time"] < least.get(name, {"cpu_time": float("inf")})["cpu_time"]:
            least[name] = b
    for name, b in least.items():
        n, seconds = round(b["n"]), b["cpu_time"] * unit[b["time_unit"]]
        each, target = seconds / n * 1e6, TARGETS.get(name)
        yield {"scene": name, "n": n, "seconds": f"{seconds:.4g}", "us_per_object": f"{each:.4g}",
               **({"target": target, "target_ratio": f"{each / target:.3g}"} if target else {}),
               "contacts": round(b["contacts"]), "candidates": f"{b['candidates']:.1f}",
               "volume_error": f"{b['volume_error']:.2g}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="bench_diagram, built in Release")
    parser.add_argument("--molecules", type=pathlib.Path, help="folder of the molecules")
    parser.add_argument("--repetitions", type=int, default=3, help="of each measurement (default 3)")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=record.SOURCE / "bench/results/diagram.csv")
    options = parser.parse_args()
    arguments = [f"--benchmark_repetitions={options.repetitions}"]
    if options.molecules:
        arguments.append(f"--molecules={options.molecules}")
    report = record.report_of(options.program, arguments)
    origin = {"compiler": report["context"]["compiler"], "machine": record.machine(), "commit": record.commit()}
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows({**row, **origin} for row in rows_of(report))


if __name__ == "__main__":
    main()
