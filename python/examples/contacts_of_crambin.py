"""Which atoms of crambin (1CRN) share a face, and how large it is: the contact map of all 327 atoms.

contacts_of_crambin.py [contacts.png]
"""
import pathlib
import sys

import numpy as np

import vcell

file = pathlib.Path(__file__).resolve().parents[2] / "tests/data/1CRN.xyzr"


def draw(table, atoms, exposed, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 5.4), gridspec_kw={"width_ratios": [1.1, 1]})
    order = np.argsort(table.area[atoms])  # large faces on top
    first, second, area = (x[atoms][order] for x in (table.first, table.second, table.area))
    marks = left.scatter(np.concatenate([first, second]), np.concatenate([second, first]), s=4,
                         c=np.concatenate([area, area]), cmap="viridis_r", vmax=np.quantile(area, 0.98))
    left.set(xlabel="atom", ylabel="atom", title="faces between atoms", aspect="equal")
    left.invert_yaxis()
    figure.colorbar(marks, ax=left, label="area, Å²")
    right.bar(np.arange(len(exposed)), exposed, width=1.0, color="tab:orange")
    right.set(xlabel="atom", ylabel="area, Å²", title="accessible surface at 1.4 Å", xlim=(-1, len(exposed)))
    figure.tight_layout()
    figure.savefig(path, dpi=100)


def main():
    scene = vcell.read_diagram_scene(file, probe=1.4)
    diagram = vcell.diagram(scene)
    table = diagram.contacts()
    atoms = table.second >= 0
    assert not table.faults
    print(f"{len(diagram)} atoms, {atoms.sum()} contacts that a probe of 1.4 sees, {table.area[atoms].sum():.1f} in all")
    print(f"volume {diagram.volume.sum():.1f}, accessible surface {diagram.exposed_area.sum():.2f} +- "
          f"{diagram.exposed_error.sum():.0e}, of {np.count_nonzero(diagram.exposed_area)} atoms")
    if len(sys.argv) > 1:
        draw(table, atoms, diagram.exposed_area, sys.argv[1])


if __name__ == "__main__":
    main()
