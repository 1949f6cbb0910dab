#!/usr/bin/env python3
"""Is one build slower than another? Runs the benches of both in turns, on one machine, and compares.

    bench/gate.py build/release ../before/build/release

prints a line for each bench: CPU time of the first build over that of the second, each the least of the rounds,
and for each example scene the signs decided over those of the second build, by doubles and by what is more
expensive. Exit status 1: a bench is more than 3 % slower, a scene asks for more than 2 % more signs (scenes of fewer
than a thousand: 20 more).
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent

BENCHES = {
    "bench_envelope": "random/10000|lattice/100",
    "bench_mixed": "scene/figure5|scene/figure6|scene/pile_50$|scene/pile_500|scene/table3_24",
    "bench_radial": "scene/figure8|scene/figure9|scene/figure10|around/1000$|tubes",
    "bench_solver": "four_spheres/scene|plane_sphere_two_cylinders/scene|four_cylinders/scene",
}
MOST_SLOWER = 1.03
MOST_SIGNS = 1.02
FEW_SIGNS = 20


def seconds(build, bench, filter_):
    """{name: CPU seconds of one call} of one run."""
    out = subprocess.run([build / "bench" / bench, f"--benchmark_filter={filter_}", "--benchmark_format=json",
                          "--benchmark_min_time=0.2"], capture_output=True, text=True, check=True).stdout
    unit = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1}
    return {row["name"]: row["cpu_time"] * unit[row["time_unit"]] for row in json.loads(out)["benchmarks"]
            if row["run_type"] == "iteration"}


def decisions(build, scene):
    """Signs decided by doubles, and by what is more expensive; None where the scene is refused."""
    with tempfile.TemporaryDirectory() as folder:
        cell = pathlib.Path(folder) / "cell.json"
        subprocess.run([build / "apps" / "vcell", "compute", scene, "-o", cell], capture_output=True)
        if not cell.exists():
            return None
        counts = json.loads(cell.read_text())["report"]["decisions"]
    return counts["double"], sum(counts[k] for k in ("interval", "exact", "multiprecision"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("new", type=pathlib.Path, help="a build's folder")
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    new, old = arguments.new.resolve(), arguments.old.resolve()
    is_slower = False

    for bench, filter_ in BENCHES.items():
        least = {new: {}, old: {}}
        for k in range(arguments.rounds):
            for build in (new, old) if k % 2 else (old, new):
                for name, time in seconds(build, bench, filter_).items():
                    least[build][name] = min(time, least[build].get(name, time))
        for name in least[old]:
            ratio = least[new][name] / least[old][name]
            is_slower |= ratio > MOST_SLOWER
            print(f"{bench + '/' + name:54} {ratio:6.3f}  {least[new][name]:.3g} s{'  SLOWER' * (ratio > MOST_SLOWER)}")

    for scene in sorted((ROOT / "examples" / "scenes").glob("*.json")):
        counts = decisions(new, scene), decisions(old, scene)
        if None in counts:
            print(f"{scene.stem:54} {'refused by ' + ('the second' if counts[0] else 'the first') + ' build'}")
            is_slower |= counts[0] is None
            continue
        more = any(a > MOST_SIGNS * b + (FEW_SIGNS if b < 1000 else 0) for a, b in zip(*counts))
        is_slower |= more
        print(f"{scene.stem:54} {counts[0][0]} / {counts[1][0]} by doubles, {counts[0][1]} / {counts[1][1]} otherwise"
              f"{'  MORE' * more}")
    sys.exit(is_slower)


if __name__ == "__main__":
    main()
