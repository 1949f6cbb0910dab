#!/usr/bin/env python3
"""Draws docs/pictures: make_pictures.py [--program build/release/apps/vcell] [NAME ...]

Of every scene below, or of those NAMEd: its minimization diagram as SVG, or the cell with base and objects as PNG
(view_obj.py), or both.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import view_obj

SOURCE = pathlib.Path(__file__).resolve().parent.parent

DIAGRAMS = ["table3_24", "hundreds", "pile_50", "figure1", "figure2", "figure8", "figure10"]
# Options of view_obj.draw().
Z_UP = {"up": (0, 0, 1)}
VIEWS = {
    "figure1": {"viewer": (-2, -5, 1.5), **Z_UP},
    "figure2": {"viewer": (-2, -5, 1.5), **Z_UP},
    "figure5": {"viewer": (-2, -5, 1.5), **Z_UP},
    "figure6": {"viewer": (-2, -5, 1.5), **Z_UP},
    "figure7": {"viewer": (3, -4, 2), "sixth": "+z", **Z_UP},
    "figure8": {"viewer": (3, -4, 2), **Z_UP},
    "figure9": {"viewer": (3, -4, 2), **Z_UP},
    "figure10": {"viewer": (1.5, -4, 2.5), **Z_UP},
    "figure12": {"viewer": (-2, -5, 2.5), **Z_UP},
    "cage": {},
    "bundle": {},
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--program", type=pathlib.Path, default=SOURCE / "build/release/apps/vcell")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=SOURCE / "docs/pictures")
    options = parser.parse_args()
    for name in sorted({*DIAGRAMS, *VIEWS}):
        if options.names and name not in options.names:
            continue
        path = SOURCE / f"examples/scenes/{name}.json"
        with tempfile.TemporaryDirectory() as folder:
            mesh = pathlib.Path(folder) / "cell.obj"
            outputs = ["-o", options.output / f"{name}.svg"] if name in DIAGRAMS else []
            outputs += ["-o", mesh] if name in VIEWS else []
            subprocess.run([options.program, "compute", path, *outputs], check=True)
            if name in VIEWS:
                scene = json.loads(path.read_text(encoding="utf-8"))
                view_obj.draw(mesh, options.output / f"{name}.png", scene, **VIEWS[name])
        print(name)


if __name__ == "__main__":
    main()
