"""The cell of a ball among balls, drawn with matplotlib: faces in the colours of their owners, edges as curves.

cell_of_a_ball.py [cell.png]
"""
import pathlib
import sys

import numpy as np

import vcell

scenes = pathlib.Path(__file__).resolve().parents[2] / "examples/scenes"


def draw(cell, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = plt.figure(figsize=(6, 6))
    axes = figure.add_axes((0, 0, 1, 1), projection="3d", proj_type="ortho", computed_zorder=False)
    elevation, azimuth = np.radians(24), np.radians(-55)
    axes.view_init(np.degrees(elevation), np.degrees(azimuth))
    towards_eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])

    mesh = vcell.mesh(cell, chord=0.01)
    triangles = mesh.points[mesh.triangles]
    normals = mesh.normals[mesh.corner_normals].mean(axis=1)
    shade = 0.6 + 0.4 * np.clip(normals @ (towards_eye + (0.2, 0, 0.6)) / 1.3, 0, 1)
    colours = np.array(plt.get_cmap("tab10").colors)[mesh.triangle_faces % 10] * shade[:, None]
    faces_eye = normals @ towards_eye > 0
    axes.add_collection3d(Poly3DCollection(triangles[faces_eye], facecolors=colours[faces_eye],
                                           edgecolors=colours[faces_eye], linewidths=0.8, zorder=1))
    seen = set(mesh.triangles[faces_eye].ravel())
    for edge, line in zip(cell.edges, mesh.edge_lines):
        if seen.issuperset(line):
            axes.plot(*edge.curve.evaluate(np.linspace(*edge.curve.domain, 60)).T, color="black", linewidth=1.5, zorder=2)
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low, zoom=1.7)
    axes.set_axis_off()
    figure.savefig(path, dpi=80)


def main():
    scene = vcell.read_scene(scenes / "figure8.json")
    cell = vcell.cell(scene)
    print(f"{len(cell.faces)} faces, {len(cell.edges)} edges, {len(cell.vertices)} vertices, "
          f"volume {cell.measures.volume:.6f} +- {cell.measures.volume_error:.0e}, "
          f"{'proved' if vcell.check(cell) else 'not proved'}")
    for face in cell.faces:
        print(f"face with {face.site}: {face.bisector}, area {face.area:.6f}")
    if len(sys.argv) > 1:
        draw(cell, sys.argv[1])


if __name__ == "__main__":
    main()
