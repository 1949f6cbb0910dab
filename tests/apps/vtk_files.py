"""Meshes that the program writes as .vtu and .ply, read by VTK: vtk_files.py PROGRAM SCENES FOLDER

VTK, ParaView's library, is not among .ci/packages (Debian's python3-vtk9); without it nothing is tested, which is said.
"""
import json
import math
import pathlib
import subprocess
import sys

try:
    import vtk
except ImportError:
    print("skipped: no VTK for this Python (Debian's package is python3-vtk9)")
    sys.exit(0)

faults = []


def check(is_so, what):
    if not is_so:
        faults.append(what)


def arrays(data):
    return {data.GetArrayName(i): data.GetArray(i) for i in range(data.GetNumberOfArrays())}


def read(path):
    reader = vtk.vtkXMLUnstructuredGridReader() if path.suffix == ".vtu" else vtk.vtkPLYReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def surface(grid):
    if isinstance(grid, vtk.vtkPolyData):
        return grid
    to_surface = vtk.vtkGeometryFilter()
    to_surface.SetInputData(grid)
    to_surface.Update()
    return to_surface.GetOutput()


def loose_edges(mesh):
    """Sides of triangles that do not belong to two of them, each seen the other way round."""
    edges = vtk.vtkFeatureEdges()
    edges.SetInputData(mesh)
    edges.FeatureEdgesOff()
    edges.ManifoldEdgesOff()
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


def volume(mesh):
    mass = vtk.vtkMassProperties()
    mass.SetInputData(mesh)
    mass.Update()
    return mass.GetVolume()


def bernstein(degree, t):
    return [math.comb(degree, k) * t**k * (1 - t) ** (degree - k) for k in range(degree + 1)]


def on_patch(patch, u, v):
    """Its point at parts u and v of its domain."""
    m, n = patch["degree"]
    sums = [0.0] * 4
    for i, a in enumerate(bernstein(m, u)):
        for j, b in enumerate(bernstein(n, v)):
            x, y, z, w = patch["points"][i][j]
            for k, c in enumerate((x * w, y * w, z * w, w)):
                sums[k] += a * b * c
    return [s / sums[3] for s in sums[:3]]


def location(element, u, v):
    """The element's point at parameters, by VTK."""
    at, weights = [0.0] * 3, [0.0] * element.GetNumberOfPoints()
    element.EvaluateLocation(vtk.reference(0), (u, v, 0), at, weights)
    return at


def check_bezier(path, cell):
    """VTK's rational Bezier elements are the cell's patches, and its curves begin and end in the cell's vertices."""
    grid = read(path)
    of_cells = arrays(grid.GetCellData())
    size = max(max(map(abs, p[:3])) for f in cell["faces"] for q in f["patches"] for row in q["points"] for p in row)
    patches = [(f, q) for f, face in enumerate(cell["faces"]) for q in face["patches"]]
    curves = 0
    for i in range(grid.GetNumberOfCells()):
        element = grid.GetCell(i)
        if i >= len(patches):
            curves += 1
            check(isinstance(element, vtk.vtkBezierCurve) and of_cells["face"].GetValue(i) == -1, f"{path.name}: {i}")
            continue
        face, patch = patches[i]
        check(isinstance(element, vtk.vtkBezierQuadrilateral), f"{path.name}: {i} is no quadrilateral")
        check(of_cells["face"].GetValue(i) == face, f"{path.name}: {i} is of another face")
        for u in (0, 0.3, 1):
            for v in (0, 0.6, 1):
                away = math.dist(location(element, u, v), on_patch(patch, u, v))
                check(away < 1e-12 * size, f"{path.name}: element {i} is {away} from its patch")
    check(curves >= len(cell["edges"]), f"{path.name}: {curves} curves of {len(cell['edges'])} edges")


def main():
    program, scenes, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    folder.mkdir(parents=True, exist_ok=True)

    def run(*arguments, **more):
        return subprocess.run([program, *map(str, arguments)], check=True, capture_output=True, text=True, **more).stdout

    for name in ("figure8", "three_tubes", "figure10"):
        scene = scenes / f"{name}.json"
        files = [folder / f"{name}.vtu", folder / f"{name}.ply"]
        run("compute", scene, "--solid", "-o", files[0], "-o", files[1])
        measured = float(run("measure", scene).splitlines()[1].split("\t")[0])
        for file in files:
            mesh = surface(read(file))
            check(mesh.GetNumberOfCells() > 0 and loose_edges(mesh) == 0, f"{file.name}: not closed")
            check(abs(volume(mesh) / measured - 1) < 0.01, f"{file.name}: volume {volume(mesh)}, measured {measured}")
        of_cells, of_points = arrays(read(files[0]).GetCellData()), arrays(read(files[0]).GetPointData())
        check({"cell", "neighbor"} <= set(of_cells) and "clearance" in of_points, f"{name}.vtu: arrays {of_cells}")

    for name in ("figure8", "three_tubes", "table3_04"):
        files = [folder / f"{name}.json", folder / f"{name}.bezier.vtu"]
        run("compute", scenes / f"{name}.json", "-o", files[0], "-o", files[1])
        check_bezier(files[1], json.loads(files[0].read_text()))

    # Each cell of a diagram is a closed mesh, all of them fill the box, and porosity is there as the tables tell it.
    balls = "".join(f"{x} {y} {z} 0.{3 + (x + y + z) % 2}\n" for x in range(2) for y in range(2) for z in range(2))
    table = folder / "cells.tsv"
    run("diagram", "-", "--box", -1, -1, -1, 2, 2, 2, "--bodies", "--cells", table, "-o", folder / "all.vtu", input=balls)
    rows = [line.split("\t") for line in table.read_text().splitlines()]
    grid, column = read(folder / "all.vtu"), {name: i for i, name in enumerate(rows[0])}
    of_cells = arrays(grid.GetCellData())
    total = 0
    for row in rows[1:]:
        number = int(row[column["object"]])
        of_cell = vtk.vtkThreshold()
        of_cell.SetInputData(grid)
        of_cell.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_CELLS, "cell")
        of_cell.SetLowerThreshold(number)
        of_cell.SetUpperThreshold(number)
        of_cell.Update()
        mesh = surface(of_cell.GetOutput())
        check(loose_edges(mesh) == 0, f"all.vtu: cell {number} is not closed")
        total += volume(mesh)
        porosity = 1 - float(row[column["body_volume"]]) / float(row[column["volume"]])
        told = arrays(of_cell.GetOutput().GetCellData())["porosity"].GetRange()
        check(abs(told[0] - porosity) < 1e-15 and told[0] == told[1], f"all.vtu: porosity of {number} is {told}")
    check(len(rows) == 9 and abs(total - 27) < 1e-6, f"all.vtu: {len(rows) - 1} cells of volume {total}")
    run("diagram", "-", "--box", -1, -1, -1, 2, 2, 2, "--chord", "2%", "-o", folder / "coarse.vtu", input=balls)
    coarse = read(folder / "coarse.vtu")
    run("diagram", "-", "--box", -1, -1, -1, 2, 2, 2, "-o", folder / "all.bezier.vtu", "-o", folder / "all.json", input=balls)
    exact, cells = read(folder / "all.bezier.vtu"), json.loads((folder / "all.json").read_text())["cells"]
    patches = [(i, f) for i, c in enumerate(cells) for f, face in enumerate(c["faces"]) for _ in face["patches"]]
    numbers = arrays(exact.GetCellData())
    told = [(numbers["cell"].GetValue(i), numbers["face"].GetValue(i)) for i in range(exact.GetNumberOfCells())]
    check([t for t in told if t[1] >= 0] == patches, f"all.bezier.vtu: patches {told}")
    check(0 < 2 * coarse.GetNumberOfCells() < grid.GetNumberOfCells(), f"coarse.vtu: {coarse.GetNumberOfCells()} triangles")
    check({"cell", "neighbor", "volume", "porosity"} <= set(of_cells), f"all.vtu: arrays {set(of_cells)}")
    print(*(faults or ["VTK reads what was written"]), sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
