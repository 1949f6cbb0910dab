"""How vcell-mpi's exchange grows: rounds, questions, ghosts and bytes for each ball, of random balls in a box that repeats.

mpi_growth.py VCELL_MPI RANKS BALLS_PER_RANK [RANKS BALLS_PER_RANK ...]

Prints a row for each pair. Blocks of a box that repeats have neighbours on all sides, so few ranks show what many do.
Figures other than seconds are the same on any machine; ranks may be more than cores.
"""
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile


def write_balls(path, count):
    rng = random.Random(17)
    spacing = count ** (-1 / 3)
    with open(path, "w") as out:
        for _ in range(count):
            x, y, z, r = (rng.random() for _ in range(4))
            out.write(f"{x!r} {y!r} {z!r} {0.35 * spacing * r!r}\n")


def measure(program, ranks, per_rank, folder):
    balls, table = folder / "balls.txt", folder / "statistics.tsv"
    write_balls(balls, ranks * per_rank)
    environment = dict(os.environ, OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_btl_vader_single_copy_mechanism="none")
    subprocess.run(["mpirun", "-n", str(ranks), program, "diagram", str(balls), "--box", "0", "0", "0", "1", "1", "1",
                    "--periodic", "xyz", "--statistics", str(table)],
                   env=environment, check=True, stdout=subprocess.DEVNULL)
    header, *lines = (line.split("\t") for line in table.read_text().splitlines())
    rows = [dict(zip(header, map(float, line))) for line in lines]
    mean = {key: statistics.fmean(row[key] for row in rows) for key in header}
    own = mean["objects"]
    # A cube of m balls within a layer w spacings thick has (m^(1/3) + 2 w)^3 of them.
    layer = ((own + mean["ghosts"]) ** (1 / 3) - own ** (1 / 3)) / 2
    print(f"{ranks}\t{per_rank}\t{max(row['objects'] for row in rows) / own:.3f}\t{mean['rounds']:.0f}\t"
          f"{mean['asking'] / own:.3f}\t{mean['questions'] / own:.3f}\t{mean['ghosts'] / own:.3f}\t"
          f"{mean['bytes'] / own:.0f}\t{layer:.2f}\t{mean['rounds_s']:.2f}\t{mean['cells_s']:.2f}", flush=True)


def main():
    program, *numbers = sys.argv[1:]
    print("ranks\tballs_per_rank\tlargest_block\trounds\tasking\tquestions\tghosts\tbytes\tlayer\trounds_s\tcells_s")
    with tempfile.TemporaryDirectory() as folder:
        for ranks, per_rank in zip(numbers[::2], numbers[1::2]):
            measure(program, int(ranks), int(per_rank), pathlib.Path(folder))


if __name__ == "__main__":
    main()
