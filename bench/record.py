#!/usr/bin/env python3
"""Runs bench_envelope and writes its measurements as CSV.

    bench/record.py build/release/bench/bench_envelope --max-n 1000000

Each family of scenes runs in a process of its own, so that peak_MB, a maximum over the process with
ascending sizes, belongs to the size in its row. Times are CPU seconds of lower_envelope(), median and least
of the repetitions; t2n_over_tn is the ratio to the time at n / 2, where that size was measured too. Decisions
are those of one call. The commit is that of the source tree this script lies in ("+" when files differ from
it): build there before recording. Exit status 1: the bench failed, or found a wrong diagram.
"""
import argparse
import csv
import json
import math
import pathlib
import platform
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parent.parent
FAMILIES = ("random", "lattice")
DECISIONS = ("double", "interval", "exact", "multiprecision", "assumed")
COLUMNS = ("scene", "n", "seconds", "seconds_min", "V", "E", "F", "closed", *DECISIONS, "cheap_share",
           "us_per_sphere", "peak_MB", "t2n_over_tn", "compiler", "machine", "commit")


def machine():
    try:
        for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def commit():
    def git(*arguments):
        return subprocess.run(["git", "-C", str(SOURCE), *arguments], check=True, capture_output=True,
                              text=True).stdout.strip()

    # The recorded results do not change what was measured.
    changed = git("status", "--porcelain", "--", ".", ":!bench/results")
    return git("rev-parse", "--short=10", "HEAD") + ("+" if changed else "")


def report_of(program, arguments):
    """The JSON of one run of a bench; a run that fails ends the script."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.json"
        status = subprocess.run([program, *arguments, f"--benchmark_out={out}", "--benchmark_out_format=json"],
                                check=False).returncode
        if status != 0:
            sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {program} {' '.join(map(str, arguments))} failed")
        return json.loads(out.read_text())


def run(program, family, options):
    """The bench's JSON for one family."""
    return report_of(program, [f"--max_n={options.max_n}", f"--benchmark_filter=^{family}/",
                               f"--benchmark_repetitions={options.repetitions}",
                               f"--benchmark_min_time={options.min_time}"])


def rows_of(family, report, common):
    runs = {}
    for b in report["benchmarks"]:
        if b["run_type"] == "iteration":
            runs.setdefault(round(b["n"]), []).append(b)
    scale = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
    times = {n: sorted(b["cpu_time"] * scale[b["time_unit"]] for b in bs) for n, bs in runs.items()}
    median = {n: (t[(len(t) - 1) // 2] + t[len(t) // 2]) / 2 for n, t in times.items()}
    for n, bs in sorted(runs.items()):
        counted = {name: round(bs[0][name]) for name in ("V", "E", "F", "closed", *DECISIONS)}
        yield {
            "scene": family, "n": n, "seconds": f"{median[n]:.4g}", "seconds_min": f"{times[n][0]:.4g}",
            **counted, "cheap_share": f"{bs[0]['cheap']:.6f}", "us_per_sphere": f"{median[n] / n * 1e6:.3f}",
            "peak_MB": f"{bs[0]['peak_MB']:.1f}",
            "t2n_over_tn": f"{median[n] / median[n // 2]:.2f}" if n % 2 == 0 and n // 2 in median else "",
            **common,
        }


def fit(rows):
    """c and the relative RMS error of seconds = c n log2 n, least squares of the relative errors."""
    ratio = [float(r["seconds"]) / (r["n"] * math.log2(r["n"])) for r in rows]
    c = sum(1 / x for x in ratio) / sum(1 / x**2 for x in ratio)
    return c, math.sqrt(sum((c / x - 1) ** 2 for x in ratio) / len(ratio))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="the built bench_envelope")
    parser.add_argument("--max-n", type=int, default=10000, help="largest scene (default 10000)")
    parser.add_argument("--repetitions", type=int, default=5, help="of each measurement (default 5)")
    parser.add_argument("--min-time", type=float, default=0.2, help="seconds of a repetition (default 0.2)")
    parser.add_argument("-o", "--output", default=str(SOURCE / "bench/results/envelope.csv"))
    options = parser.parse_args()

    pathlib.Path(options.output).parent.mkdir(parents=True, exist_ok=True)
    rows = []
    for family in FAMILIES:
        report = run(options.program, family, options)
        common = {"compiler": report["context"]["compiler"], "machine": machine(), "commit": commit()}
        rows += rows_of(family, report, common)
    with open(options.output, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    c, error = fit([r for r in rows if r["scene"] == "random"])
    print(f"{options.output}: random scenes take {c * 1e9:.3g} ns n log2 n, RMS error {100 * error:.0f} %")


if __name__ == "__main__":
    main()
