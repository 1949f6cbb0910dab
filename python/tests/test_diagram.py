"""Whole diagrams, against distances and sums computed here."""
import itertools

import numpy as np
import pytest
from conftest import distances

import vcell

box = vcell.Box((0, 0, 0), (10, 10, 10))


@pytest.fixture
def diagram(balls):
    return vcell.diagram(vcell.DiagramScene(balls, box))


def test_volumes_sum_to_the_box(diagram):
    assert diagram.states == ["computed"] * 40 and diagram.reasons == [""] * 40
    assert abs(diagram.volume.sum() - 1000) <= diagram.volume_error.sum()
    filled = diagram.filled_volume()
    assert filled.fills and filled.box == 1000 and filled.volume == pytest.approx(diagram.volume.sum())


def test_volumes_are_those_of_the_nearest_objects(diagram, balls, rng):
    points = rng.uniform(0, 10, (40000, 3))
    nearest = np.argmin(np.linalg.norm(points[:, None] - balls[None, :, :3], axis=2) - balls[:, 3], axis=1)
    part = np.bincount(nearest, minlength=40) / len(points)
    assert np.all(np.abs(part - diagram.volume / 1000) < 5 * np.sqrt(part * (1 - part) / len(points)) + 1e-3)


def test_contacts_are_symmetric(diagram, balls):
    table = diagram.contacts()
    assert table.faults == [] and len(table) == len(table.first) == len(table.area)
    assert np.all((table.second < 0) | (table.second >= table.first)) and np.all(table.image == 0)
    # A cell computed by itself has the same neighbours and areas, seen from either side.
    area = {(a, b): s for a, b, s in zip(table.first, table.second, table.area)}
    for number in (0, 17):
        scene = vcell.Scene(vcell.Sphere(balls[number, :3], balls[number, 3]), balls, box, base_object=number)
        cell = vcell.cell(scene)
        seen = {}
        for site, s in zip(cell.face_sites, cell.face_areas):
            key = (number, site) if site < 0 or site > number else (site, number)
            seen[key] = seen.get(key, 0) + s
        mine = {key: s for key, s in area.items() if number in key}
        assert seen.keys() == mine.keys()
        assert all(seen[key] == pytest.approx(mine[key], rel=1e-9) for key in seen)
    objects = table.second >= 0
    degree = np.bincount(np.concatenate([table.first[objects], table.second[objects]]), minlength=40)
    assert np.array_equal(degree, diagram.neighbor_count)
    of_pairs = np.bincount(table.first[objects], table.area[objects], 40) + np.bincount(
        table.second[objects], table.area[objects], 40)
    assert np.allclose(of_pairs, diagram.area, rtol=1e-9)
    assert np.array_equal(np.bincount(table.first[~objects], minlength=40) > 0, diagram.touches_box)


def test_areas_on_the_box_sum_to_it(diagram):
    table = diagram.contacts()
    for side in range(6):
        assert table.area[table.second == -1 - side].sum() == pytest.approx(100, rel=1e-9)


def test_files_of_all_cells(balls, tmp_path):
    endings = ("json", "obj", "stl", "ply", "vtu", "bezier.vtu", "glb", "3mf", "step", "itd", "html", "svg")
    files = [tmp_path / f"all.{ending}" for ending in endings]
    scene, seen = vcell.DiagramScene(balls[:6], box), []
    diagram = vcell.diagram(scene, visit=lambda i, _: seen.append(i), outputs=files, chord=0.02, cut=("z", 5))
    assert seen == list(range(6)) and diagram.filled_volume().fills
    assert all(file.stat().st_size > 1000 for file in files) and (tmp_path / "all.mtl").exists()
    assert files[endings.index("step")].read_text().count("MANIFOLD_SOLID_BREP") == 6
    vcell.diagram(scene, outputs=[files[1]])
    triangles = files[1].read_text().count("\nf ")
    with pytest.warns(UserWarning, match=f"^a chord of 0.002 is too fine for {triangles - 1} triangles .* of 0.008$"):
        vcell.diagram(scene, outputs=[files[1]], most_triangles=triangles - 1)
    assert 100 < files[1].read_text().count("\nf ") < triangles
    with pytest.raises(ValueError, match="^the coarsest mesh has [0-9]+ triangles, not 1 at most$"):
        vcell.diagram(scene, outputs=[files[1]], most_triangles=1)
    with pytest.raises(ValueError, match="must end in"):
        vcell.diagram(scene, outputs=["all.xyz"])
    with pytest.raises(ValueError, match="given twice"):
        vcell.diagram(scene, outputs=[files[0], files[0]])
    with pytest.raises(ValueError, match="cut"):
        vcell.diagram(scene, outputs=files[-1:], cut=("w", 5))


def test_a_lattice_that_repeats():
    scene = vcell.DiagramScene([vcell.Sphere((0.3, 0.2, 0.1), 0.25)], [(0, 0, 0), (2, 2, 2)], periodic=(True,) * 3)
    diagram = vcell.diagram(scene)
    table = diagram.contacts()
    assert diagram.volume[0] == pytest.approx(8, rel=1e-12)
    assert len(table) == 3 and np.array_equal(np.abs(table.image).sum(axis=1), [1, 1, 1])
    assert np.all(table.first == 0) and np.all(table.second == 0) and np.allclose(table.area, 4)
    network = vcell.void_network(scene)
    assert network.included.diameter == pytest.approx(2 * np.sqrt(3) - 0.5, abs=network.included.error + 1e-12)
    assert network.free.diameter == pytest.approx(2 * np.sqrt(2) - 0.5, abs=network.free.error + 1e-12)
    # The middle of eight balls, six edges from it through the middles of four.
    assert len(network.vertex_points) == 1 and len(network.edge_vertices) == 3
    assert network.vertex_clearances[0] == pytest.approx(np.sqrt(3) - 0.25)
    assert np.allclose(network.edge_bottlenecks, np.sqrt(2) - 0.25) and np.allclose(network.edge_lengths, 2)
    assert np.all(np.abs(network.edge_images).sum(axis=1) == 1)


def test_tubes_that_repeat_have_periods_and_complete_cells():
    tubes = [vcell.Cylinder((0.5, 0.5, 0), (0, 0, 1), 0.2), vcell.Cylinder((1.5, 1.5, 0), (1, 1, 0), 0.1)]
    scene = vcell.DiagramScene(tubes + [vcell.Sphere((1.5, 0.5, 0.5), 0.2)], [(0, 0, 0), (2, 2, 2)], periodic=(True,) * 3)
    seen = []
    diagram = vcell.diagram(scene, visit=lambda i, _: seen.append(i), complete=True)
    assert diagram.states == ["computed"] * 3 and diagram.filled_volume().fills
    assert diagram.periods == {0: [[0, 0, 1]], 1: [[1, 1, 0]]}
    assert seen == [0, 1, 2]
    seen.clear()
    vcell.diagram(scene, visit=lambda i, _: seen.append(i))
    assert seen == [2]


def test_between_parallel_tubes_spheres_pass_along_edges_that_wind_and_across_passages():
    scene = vcell.DiagramScene([vcell.Cylinder((0.25, 0.25, 0), (0, 0, 1), 0.2)], [(0, 0, 0), (1, 1, 1)], periodic=(True,) * 3)
    network = vcell.void_network(scene)
    assert np.array_equal(network.edge_vertices, [[-1, -1]]) and np.array_equal(network.edge_images, [[0, 0, 1]])
    assert np.array_equal(network.passage_edges, [[0, 0]] * 2) and np.all(network.passage_images[:, 2] == 0)
    assert np.all(np.abs(network.passage_bottlenecks - 0.3) <= network.passage_bottleneck_errors)
    assert [sphere.diameter for sphere in network.free_along] == pytest.approx([0.6, 0.6, np.sqrt(2) - 0.4])


def test_void_network_vertices_are_the_farthest_places(balls):
    network = vcell.void_network(vcell.DiagramScene(balls, box))
    to_balls = np.linalg.norm(network.vertex_points[:, None] - balls[None, :, :3], axis=2) - balls[:, 3]
    assert np.all(np.abs(to_balls.min(axis=1) - network.vertex_clearances) <= 2 * network.vertex_errors + 1e-12)
    assert network.included.diameter == pytest.approx(2 * network.vertex_clearances.max())
    assert network.free is None


def test_a_probe_leaves_the_accessible_surface():
    pair = vcell.DiagramScene([vcell.Sphere((3, 5, 5), 1), vcell.Sphere((6, 5, 5), 1)], box, probe=1)
    diagram = vcell.diagram(pair)
    # Caps of balls of radius 2 whose centres are 3 apart: each loses one of height 2 - 1.5.
    assert np.isnan(diagram.body_volume).all()
    assert np.allclose(diagram.exposed_area, 4 * np.pi * 4 - 2 * np.pi * 2 * 0.5, rtol=1e-12)
    assert np.allclose(diagram.volume, 4 / 3 * np.pi * 8 - np.pi * 0.5 ** 2 * (3 * 2 - 0.5) / 3, rtol=1e-12)


def test_balls_among_tubes_and_planes(rng):
    objects = [vcell.Sphere((3, 5, 5), 1), vcell.Cylinder((7, 5, 0), (0, 0, 1), 0.5), vcell.Plane((1, 0, 0), (1, 0, 0))]
    diagram = vcell.diagram(vcell.DiagramScene(objects, box))
    assert diagram.states == ["computed"] * 3
    points = rng.uniform(0, 10, (40000, 3))
    nearest = np.argmin([distances(points, o) for o in objects], axis=0)
    part = np.bincount(nearest, minlength=3) / len(points)
    assert np.allclose(part, diagram.volume / 1000, atol=0.012)
    assert np.isnan(diagram.min_clearance[1:]).all() and diagram.min_clearance[0] > 0


def test_cells_are_visited(balls):
    seen = {}
    diagram = vcell.diagram(vcell.DiagramScene(balls, box), visit=lambda number, cell: seen.update({number: cell}))
    assert list(seen) == list(range(40))
    assert np.allclose([c.measures.volume for c in seen.values()], diagram.volume, rtol=1e-12)


def test_the_number_of_threads_changes_nothing(diagram, balls):
    assert np.array_equal(vcell.diagram(vcell.DiagramScene(balls, box), threads=1).volume, diagram.volume)


def test_update_is_the_diagram_of_the_changed_scene(diagram, balls):
    moved = balls.copy()
    moved[5, :3] += 0.2
    diagram.update(5, vcell.Sphere(moved[5, :3], moved[5, 3]))
    assert diagram.scene.objects[5] == vcell.Sphere(moved[5, :3], moved[5, 3])
    assert np.allclose(diagram.volume, vcell.diagram(vcell.DiagramScene(moved, box)).volume, rtol=1e-12)
    with pytest.raises(IndexError):
        diagram.update(40, vcell.Sphere((1, 1, 1)))


def test_objects_in_others_have_no_cell():
    diagram = vcell.diagram(vcell.DiagramScene([vcell.Sphere((5, 5, 5), 2), vcell.Sphere((5, 5, 5.5), 1)], box))
    assert diagram.states == ["computed", "empty"] and diagram.reasons[1]
    assert diagram.volume.tolist() == [pytest.approx(1000), 0]


def test_bad_scenes_are_value_errors():
    with pytest.raises(ValueError, match="groups: must be one"):
        vcell.DiagramScene(np.ones((2, 4)), box, groups=["a"])
    with pytest.raises(vcell.InputError) as caught:
        vcell.diagram(vcell.DiagramScene([vcell.Sphere((5, 5, 5), -2)], box))
    assert caught.value.path == "objects[0].sphere.radius"


def test_crambin(data):
    scene = vcell.read_diagram_scene(data / "1CRN.xyzr")
    diagram = vcell.diagram(scene)
    table = diagram.contacts()
    assert len(diagram) == 327 and len(table) == 2420 and diagram.filled_volume().fills
    grouped = vcell.read_diagram_scene(data / "crambin_head.pdb", group="residue")
    assert len(grouped.groups) == len(grouped.objects) and len(set(grouped.groups)) > 1
    with pytest.raises(ValueError, match="group: must be"):
        vcell.read_diagram_scene(data / "crambin_head.pdb", group="helix")


def test_scenes_of_all_combinations_of_periods():
    for periodic in itertools.product((False, True), repeat=3):
        scene = vcell.DiagramScene([vcell.Sphere((1, 1, 1), 0.1), vcell.Sphere((2, 2, 3), 0.2)], [(0, 0, 0), (4, 4, 4)],
                                   periodic=periodic)
        assert tuple(scene.periodic) == periodic
        assert vcell.diagram(scene).volume.sum() == pytest.approx(64, rel=1e-12)


def test_bodies_tell_the_porosity():
    balls = np.array([[1, 1, 1, 0.5], [3, 3, 3, 1]])
    scene = vcell.DiagramScene(balls, [(0, 0, 0), (4, 4, 4)])
    diagram = vcell.diagram(scene, bodies=True)
    expected = 4 / 3 * np.pi * np.array([0.125, 1])
    assert np.allclose(diagram.body_volume, expected, rtol=1e-13)
    filled = diagram.filled_by_bodies()
    assert abs(filled.volume - expected.sum()) <= filled.error and filled.box == 64 and not filled.is_estimated
    diagram.update(0, vcell.Sphere((1, 1, 1), 0.25), bodies=True)
    assert np.isclose(diagram.body_volume[0], expected[0] / 8, rtol=1e-13)


@pytest.mark.parametrize("periodic", [(False,) * 3, (True,) * 3])
def test_meshes_of_a_diagram_fit_together(balls, periodic):
    scene = vcell.DiagramScene(balls, box, periodic=periodic)
    meshes, found = vcell.DiagramMeshes(scene), {}
    vcell.diagram(scene, visit=lambda n, cell: found.update({n: meshes.add(n, cell)}))
    assert len(found) == 40 and meshes.drawn_again == 0
    volume = 0
    triangles = set()
    for n, mesh in found.items():
        corners = mesh.points[mesh.triangles]
        volume += np.linalg.det(corners).sum() / 6
        sites = mesh.triangle_sites
        assert sites.min() >= (0 if any(periodic) else -6) and sites.max() < 40
        for c, site in zip(corners, sites):
            # Turned to begin with the least corner, the sense kept.
            k = min(range(3), key=lambda i: tuple(c[i]))
            triangles.add((n, site, c[[k, (k + 1) % 3, (k + 2) % 3]].tobytes()))
    assert volume == pytest.approx(1000, rel=1e-12)
    if not any(periodic):
        for n, site, c in triangles:
            if site >= 0:
                p = np.frombuffer(c).reshape(3, 3)
                assert (site, n, p[[0, 2, 1]].tobytes()) in triangles
    with pytest.raises(ValueError, match="order"):
        meshes.add(3, vcell.cell(vcell.Scene(vcell.Sphere((5, 5, 5), 1), [], box)))
