#!/usr/bin/env python3
"""Draws docs/pictures: make_pictures.py [--program build/release/apps/vcell] [NAME ...]

Of every scene below, or of those NAMEd: its minimization diagram as SVG (vcell compute), or the cell with base and
objects as PNG (vcell draw), or both.
"""
import argparse
import pathlib
import subprocess

SOURCE = pathlib.Path(__file__).resolve().parent.parent

DIAGRAMS = ["table3_24", "hundreds", "pile_50", "figure1", "figure2", "figure8", "figure10"]
# With level curves of the clearance: NAME_contours.svg.
CONTOURS = {"leaning": "8"}
# Azimuth and elevation.
VIEWS = {
    "figure1": "-112,16",
    "figure2": "-112,16",
    "figure5": "-112,16",
    "figure6": "-112,16",
    "figure7": "-53,22",
    "figure8": "-53,22",
    "figure9": "-53,22",
    "figure10": "-69,30",
    "figure12": "-112,25",
    "cage": "-60,25",
    "bundle": "-60,25",
    "probe": "-112,25",
}
# A sixth of the cell, as in the paper's figure: what the upper side of a cube about the base ball's centre sees.
CLIPS = {"figure7": ["0 0 0 1 0 1", "0 0 0 -1 0 1", "0 0 0 0 1 1", "0 0 0 0 -1 1"]}


def arguments(description):
    """Which pictures a script makes, by which program, and where they go."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/apps/vcell")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=SOURCE / "docs/pictures")
    return parser.parse_args()


def main():
    options = arguments(__doc__)
    for name in sorted({*DIAGRAMS, *CONTOURS, *VIEWS}):
        if options.names and name not in options.names:
            continue
        scene = SOURCE / f"examples/scenes/{name}.json"
        if name in DIAGRAMS:
            subprocess.run([options.program, "compute", scene, "-o", options.output / f"{name}.svg"], check=True)
        if name in CONTOURS:
            subprocess.run([options.program, "compute", scene, "-o", options.output / f"{name}_contours.svg", "--contours",
                            CONTOURS[name]], check=True)
        if name in VIEWS:
            clips = [word for clip in CLIPS.get(name, []) for word in ("--clip", *clip.split())]
            subprocess.run([options.program, "draw", scene, "-o", options.output / f"{name}.png", "--view", VIEWS[name],
                            *clips], check=True)
        print(name)


if __name__ == "__main__":
    main()
