"""How vcell-mpi's exchange grows: rounds, questions, ghosts and bytes for each ball, of random balls in a box that repeats.

mpi_growth.py [--meshes] VCELL_MPI RANKS BALLS_PER_RANK [RANKS BALLS_PER_RANK ...]

Prints a row for each pair; with --meshes, of drawing all cells, a row for balls that are numbered at random and one for
balls that are numbered along x. Blocks of a box that repeats have neighbours on all sides, so few ranks show what many do.
Figures other than seconds are the same on any machine; ranks may be more than cores.
"""
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile


def write_balls(path, count, are_sorted=False):
    rng = random.Random(17)
    spacing = count ** (-1 / 3)
    balls = [tuple(rng.random() for _ in range(4)) for _ in range(count)]
    if are_sorted:
        balls.sort()
    with open(path, "w") as out:
        for x, y, z, r in balls:
            out.write(f"{x!r} {y!r} {z!r} {0.35 * spacing * r!r}\n")


def run(program, ranks, balls, table, *options):
    environment = dict(os.environ, OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_btl_vader_single_copy_mechanism="none")
    subprocess.run(["mpirun", "-n", str(ranks), program, "diagram", str(balls), "--box", "0", "0", "0", "1", "1", "1",
                    "--periodic", "xyz", "--statistics", str(table), *options],
                   env=environment, check=True, stdout=subprocess.DEVNULL)
    header, *lines = (line.split("\t") for line in table.read_text().splitlines())
    rows = [dict(zip(header, map(float, line))) for line in lines]
    return rows, {key: statistics.fmean(row[key] for row in rows) for key in header}


def measure_meshes(program, ranks, per_rank, folder):
    balls, mesh = folder / "balls.txt", folder / "cells.vtkhdf"
    for are_sorted in (False, True):
        write_balls(balls, ranks * per_rank, are_sorted)
        _, mean = run(program, ranks, balls, folder / "statistics.tsv", "-o", str(mesh))
        print(f"{ranks}\t{per_rank}\t{'along x' if are_sorted else 'at random'}\t{mean['mesh_rounds']:.0f}\t"
              f"{mean['bytes_in_all'] / mean['objects']:.0f}\t{mesh.stat().st_size / ranks / mean['objects']:.0f}\t"
              f"{mean['cells_s']:.2f}", flush=True)


def measure(program, ranks, per_rank, folder):
    balls = folder / "balls.txt"
    write_balls(balls, ranks * per_rank)
    rows, mean = run(program, ranks, balls, folder / "statistics.tsv")
    own = mean["objects"]
    # A cube of m balls within a layer w spacings thick has (m^(1/3) + 2 w)^3 of them.
    layer = ((own + mean["ghosts"]) ** (1 / 3) - own ** (1 / 3)) / 2
    print(f"{ranks}\t{per_rank}\t{max(row['objects'] for row in rows) / own:.3f}\t{mean['rounds']:.0f}\t"
          f"{mean['asking'] / own:.3f}\t{mean['questions'] / own:.3f}\t{mean['ghosts'] / own:.3f}\t"
          f"{mean['bytes'] / own:.0f}\t{layer:.2f}\t{mean['rounds_s']:.2f}\t{mean['cells_s']:.2f}", flush=True)


def main():
    arguments = sys.argv[1:]
    has_meshes = arguments[0] == "--meshes"
    program, *numbers = arguments[has_meshes:]
    print("ranks\tballs_per_rank\tnumbered\tmesh_rounds\tbytes_sent\tbytes_in_file\tcells_s" if has_meshes else
          "ranks\tballs_per_rank\tlargest_block\trounds\tasking\tquestions\tghosts\tbytes\tlayer\trounds_s\tcells_s")
    with tempfile.TemporaryDirectory() as folder:
        for ranks, per_rank in zip(numbers[::2], numbers[1::2]):
            (measure_meshes if has_meshes else measure)(program, int(ranks), int(per_rank), pathlib.Path(folder))


if __name__ == "__main__":
    main()
