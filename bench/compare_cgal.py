#!/usr/bin/env python3
"""Compares lower_envelope() with a program that computes the same envelopes with CGAL.

    bench/compare_cgal.py PEER DATA...

PEER is not part of this project: a program that is called as `PEER file --reps R` and prints one line of names
and values with at least n, V, E, F, xext (vertices that only cut a circle at its leftmost and rightmost points)
and cpu_ms, the median CPU time of an envelope in milliseconds. Data files hold `xmin ymin xmax ymax`, then
`x y z r` for every sphere over the plane z = 0.

On each file the two programs take turns, in processes of their own with equally many repetitions; the printed
times are medians over the turns. Both must find the same diagram: V and E of the peer less its xext, E of ours
less its closed edges, since such a circle has no vertices with us, and two with the peer, both in xext.
The rows are written to bench/results/cgal.csv too. Exit status 1: they disagree, or one failed.
"""
import argparse
import csv
import pathlib
import statistics
import subprocess
import sys

import record

SOURCE = pathlib.Path(__file__).resolve().parent.parent
COUNTS = ("n", "V", "E", "F")


def run(program, path, reps):
    """The line of the program as a dictionary of strings."""
    result = subprocess.run([program, path, "--reps", str(reps)], check=False, stdout=subprocess.PIPE, text=True)
    if result.returncode != 0:
        sys.exit(f"compare_cgal.py: {program} failed on {path}")
    words = result.stdout.split()
    return dict(zip(words[::2], words[1::2]))


def counts(line, cut_vertices, cut_edges):
    numbers = {name: int(line[name]) for name in COUNTS}
    numbers["V"] -= cut_vertices
    numbers["E"] -= cut_edges
    return numbers


def compare(peer, ours, path, turns, seconds):
    """Prints one row, and returns it; None if they do not agree."""
    # The first run of the peer tells how many repetitions fill the time, and warms the file cache.
    once = float(run(peer, path, 1)["cpu_ms"]) / 1e3
    reps = max(1, min(100, int(seconds / once)))
    peer_ms, our_ms, agree = [], [], True
    for _ in range(turns):
        p, o = run(peer, path, reps), run(ours, path, reps)
        peer_ms.append(float(p["cpu_ms"]))
        our_ms.append(float(o["cpu_ms"]))
        peer_counts = counts(p, int(p["xext"]), int(p["xext"]))
        our_counts = counts(o, 0, int(o["closed"]))
        if peer_counts != our_counts:
            print(f"{path}: the peer finds {peer_counts}, we find {our_counts}")
            agree = False
    a, b = statistics.median(peer_ms), statistics.median(our_ms)
    print(f"{o['n']:>8} {o['V']:>8} {o['E']:>8} {o['F']:>8} {reps:>5} {a:>12.3f} {b:>12.4f} {a / b:>8.1f}",
          flush=True)
    row = {**{k: o[k] for k in COUNTS}, "peer_ms": f"{a:.4g}", "vcell_ms": f"{b:.4g}", "ratio": f"{a / b:.4g}",
           "machine": record.machine(), "commit": record.commit()}
    return row if agree else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("peer")
    parser.add_argument("data", nargs="+")
    parser.add_argument("--ours", default=str(SOURCE / "build/release/bench/envelope_of_file"),
                        help="our program (default: that of the release preset)")
    parser.add_argument("-o", "--output", default=str(SOURCE / "bench/results/cgal.csv"))
    parser.add_argument("--turns", type=int, default=3, help="runs of each program (default 3)")
    parser.add_argument("--seconds", type=float, default=3, help="about how long a run of the peer takes (default 3)")
    options = parser.parse_args()

    print(f"{'n':>8} {'V':>8} {'E':>8} {'F':>8} {'reps':>5} {'peer ms':>12} {'ours ms':>12} {'ratio':>8}")
    # A list, not a generator: every file is compared even when one disagrees.
    rows = [compare(options.peer, options.ours, path, options.turns, options.seconds) for path in options.data]
    if not all(rows):
        sys.exit(1)
    with open(options.output, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


main()
