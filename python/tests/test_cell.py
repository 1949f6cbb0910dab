"""Cells, against distances computed here."""
import gc
import pickle
from fractions import Fraction

import numpy as np
import pytest
from conftest import box_distances, distances

import vcell

floor = vcell.Plane((0, 0, 0), (0, 0, 1))


@pytest.fixture(params=["ball", "plane", "tube"])
def scene(request, balls):
    box = vcell.Box((0, 0, 0), (10, 10, 10))
    if request.param == "ball":
        return vcell.Scene(vcell.Sphere(balls[0, :3], balls[0, 3]), balls[1:], box)
    if request.param == "plane":
        return vcell.Scene(floor, balls[:12], box)
    near = [vcell.Sphere(b[:3], b[3]) for b in balls if np.hypot(b[0] - 5, b[1] - 5) > b[3] + 0.5]
    return vcell.Scene(vcell.Cylinder((5, 5, 0), (0, 0, 1), 0.25), near[:8], box)


def distance_of_site(points, scene, site):
    if site.kind == "object":
        return distances(points, scene.objects[site.index])
    assert site.kind == "box"
    return box_distances(points, scene.box)[..., site.index]


def test_vertices_are_as_far_from_the_base_as_from_their_sites(scene):
    cell = vcell.cell(scene)
    assert len(cell.vertices) > 8
    for vertex in cell.vertices:
        own = distances(vertex.point, scene.base)
        assert abs(own - vertex.clearance) <= 2 * vertex.error + 1e-12
        for site in vertex.sites:
            if site.kind == "object":
                assert abs(distance_of_site(vertex.point, scene, site) - own) <= 2 * vertex.error + 1e-12
    assert np.array_equal(cell.vertex_points, [v.point for v in cell.vertices])
    assert np.array_equal(cell.vertex_clearances, [v.clearance for v in cell.vertices])
    assert np.array_equal(cell.vertex_errors, [v.error for v in cell.vertices])


def test_edges_are_as_far_from_the_base_as_from_both_sites(scene):
    cell = vcell.cell(scene)
    for number, edge in enumerate(cell.edges):
        t = np.linspace(*edge.curve.domain, 17)
        points = edge.curve.evaluate(t)
        assert points.shape == (17, 3)
        for site in edge.sites:
            if site.kind == "object":
                gap = distance_of_site(points, scene, site) - distances(points, scene.base)
                assert np.all(np.abs(gap) <= 2 * edge.error + 1e-12)
        if edge.vertices:
            ends = cell.vertex_points[edge.vertices]
            slack = edge.error + cell.vertex_errors[edge.vertices] + 1e-12
            assert np.all(np.linalg.norm(points[[0, -1]] - ends, axis=1) <= slack)
        assert cell.edge_vertices[number].tolist() == (edge.vertices or [-1, -1])
        assert cell.edge_sites[number].tolist() == [s.number for s in edge.sites]


def test_patches_are_as_far_from_the_base_as_from_their_site(scene):
    cell = vcell.cell(scene)
    for face in cell.faces:
        for patch in face.patches:
            edges = [(trim, cell.edges[trim.edge]) for loop in patch.loops for trim in loop if trim.edge is not None]
            for trim, edge in edges:
                t = np.linspace(*trim.curve.domain, 9)
                uv = trim.curve.evaluate(t)
                points = patch.surface.evaluate(uv[:, 0], uv[:, 1])
                other = edge.curve.domain[0] + edge.curve.domain[1] - t if trim.reversed else t
                assert np.all(np.linalg.norm(points - edge.curve.evaluate(other), axis=1) <= edge.error + 1e-12)
                if face.site.kind == "object":
                    gap = distance_of_site(points, scene, face.site) - distances(points, scene.base)
                    assert np.all(np.abs(gap) <= 2 * edge.error + 1e-9)


def test_patches_inside_faces(around_a_ball):
    """The middle of a face's vertices in its parameters is a point of the bisector: rounding apart, at one distance."""
    cell = vcell.cell(around_a_ball)
    for face in cell.faces:
        if face.site.kind != "object":
            continue
        for patch in face.patches:
            corners = np.array([trim.curve.evaluate(trim.curve.domain[0]) for trim in patch.loops[0]])
            u, v = corners.mean(axis=0)
            point = patch.surface.evaluate(u, v)
            assert abs(distances(point, around_a_ball.objects[face.site.index])
                       - distances(point, around_a_ball.base)) < 1e-9
            du, dv = patch.surface.partials(u, v)
            h = 1e-6
            assert np.allclose((patch.surface.evaluate(u + h, v) - patch.surface.evaluate(u - h, v)) / (2 * h), du,
                               atol=1e-5 * (1 + np.abs(du).max()))
            assert np.dot(np.cross(du, dv), point - around_a_ball.base.center) > 0


def test_nothing_is_nearer_in_the_cell(scene, rng):
    cell = vcell.cell(scene)
    points = rng.uniform(scene.box.min, scene.box.max, (2000, 3))
    own = distances(points, scene.base)
    nearest = np.min([distances(points, o) for o in scene.objects], axis=0)
    owner, clearance, inside = vcell.query(scene, points)
    assert owner.dtype == np.int64 and clearance.dtype == np.float64 and inside.dtype == bool
    assert np.array_equal(inside, own <= nearest)
    # As many as the volume says, within five standard deviations.
    part = cell.measures.volume / np.prod(scene.box.max - scene.box.min)
    assert abs(inside.mean() - part) < 5 * np.sqrt(part * (1 - part) / len(points))
    assert set(owner[owner != vcell.NO_SITE]) <= set(cell.face_sites)
    assert np.all(clearance[owner != vcell.NO_SITE] >= cell.measures.min_clearance - 1e-9)


def test_the_owner_of_a_ray_is_nearest_at_its_clearance(around_a_ball, rng):
    base = around_a_ball.base
    directions = rng.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    owner, clearance, inside = vcell.PointQuery(around_a_ball)(base.center + directions)
    points = base.center + (base.radius + clearance)[:, None] * directions
    all_of = np.concatenate([np.stack([distances(points, o) for o in around_a_ball.objects], axis=1),
                             box_distances(points, around_a_ball.box)], axis=1)
    # Objects are as far as the base; the sides of the box are where the ray ends.
    objects = owner >= 0
    assert objects.any()
    assert np.allclose(all_of[objects, owner[objects]], clearance[objects], atol=1e-9)
    assert np.all(all_of[:, :-6].min(axis=1) >= clearance - 1e-9)
    sides = (owner < 0) & (owner >= -6)
    n = len(around_a_ball.objects)
    assert np.allclose(all_of[sides, n - 1 - owner[sides]], 0, atol=1e-9)


def test_a_sphere_has_no_ray_in_its_centre(around_a_ball):
    owner, clearance, inside = vcell.query(around_a_ball, [around_a_ball.base.center])
    assert owner[0] == vcell.NO_SITE and np.isnan(clearance[0]) and inside[0]
    with pytest.raises(ValueError, match=r"points: must have shape \(n, 3\), has \(3,\)"):
        vcell.query(around_a_ball, around_a_ball.base.center)


def test_measures_add_up(scene):
    cell = vcell.cell(scene)
    m = cell.measures
    own = cell.face_sites >= 0
    error = m.area_error + cell.face_area_errors[own].sum() + 1e-12
    assert abs(cell.face_areas[own].sum() - m.area) <= error
    assert np.all(np.diff([cell.face_areas[cell.face_sites == n].sum() for n in cell.neighbors]) <= 1e-9)
    bare = vcell.cell(scene, measure=False)
    assert np.isnan(bare.measures.volume) and len(bare.faces) == len(cell.faces)


def test_a_check_proves_the_cell(scene):
    cell = vcell.cell(scene)
    certificate = vcell.check(cell)
    assert certificate and certificate.holds and certificate.refuted == 0
    assert certificate.proved == len(certificate.elements) > len(cell.vertices)
    assert {e.verdict for e in certificate.elements} == {"proved"}


def test_a_check_refutes_a_cell_that_is_not(around_a_ball):
    cell = vcell.cell(around_a_ball)
    text = cell.to_json()
    number = repr(float(cell.measures.volume))
    assert text.count(number) == 1
    certificate = vcell.check(vcell.parse_cell(text.replace(number, repr(1.001 * cell.measures.volume))))
    assert not certificate
    assert [e.where for e in certificate.elements if e.verdict == "refuted"] == ["measures.volume"]


def test_files_of_cells(around_a_ball, tmp_path):
    cell = vcell.cell(around_a_ball)
    for ending in ("json", "svg", "html", "obj", "stl", "ply", "vtu", "glb", "3mf", "itd", "step"):
        vcell.write(cell, tmp_path / f"cell.{ending}")
        assert (tmp_path / f"cell.{ending}").stat().st_size > 1000
    for other in (vcell.read_cell(tmp_path / "cell.json"), pickle.loads(pickle.dumps(cell))):
        assert np.array_equal(other.vertex_points, cell.vertex_points)
        assert other.measures.volume == cell.measures.volume
    with pytest.raises(ValueError, match="path: must end in"):
        vcell.write(cell, tmp_path / "cell.xyz")
    with pytest.raises(OSError):
        vcell.write(cell, tmp_path / "absent" / "cell.obj")


def test_a_closed_mesh_has_the_cell_s_volume(scene):
    cell = vcell.cell(scene)
    mesh = vcell.mesh(cell, closed=True, chord=0.002)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    # The mesh is off by its chord at most, the area of the cell's boundary in all.
    m = cell.measures
    assert abs(volume - m.volume) < mesh.chord * (m.area + m.box_area + m.base_area)
    sides = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(sides, axis=0, return_counts=True)[1]) == {2}
    faces = mesh.triangle_faces
    assert set(faces[faces >= 0]) == set(range(len(cell.faces)))
    assert len(mesh.edge_lines) == len(cell.edges)
    assert not mesh.points.flags.writeable
    normals = mesh.normals[mesh.corner_normals[:, 0]]
    assert np.median(np.einsum("ij,ij->i", normals, np.cross(b - a, c - a))) > 0


def test_moments_are_those_of_the_closed_mesh(scene):
    cell = vcell.cell(scene)
    moments = vcell.moments(cell)
    mesh = vcell.mesh(cell, closed=True, chord=0.002)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    centroid = (volumes[:, None] * (a + b + c)).sum(axis=0) / 4 / volumes.sum()
    assert np.linalg.norm(centroid - moments.centroid) < 0.01
    a, b, c = (corner - moments.centroid for corner in (a, b, c))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    second = sum(np.einsum("i,ij,ik->jk", volumes / 20, p, p) for p in (a, b, c, a + b + c))
    assert moments.second.shape == (3, 3)
    assert np.allclose(second, moments.second, atol=0.01 * np.trace(second))
    assert 0 <= moments.centroid_error < 1e-3 and 0 <= moments.second_error < 1e-3 * np.trace(second)
    assert np.array_equal(vcell.moments(vcell.parse_cell(cell.to_json())).centroid, moments.centroid)


def test_places_of_the_least_and_the_greatest_clearance(scene):
    cell = vcell.cell(scene)
    places, m = vcell.clearance_places(cell), cell.measures
    for place, value, bound in ((places.least, m.min_clearance, m.min_clearance_error),
                                (places.greatest, m.max_clearance, m.max_clearance_error)):
        assert abs(place.clearance - value) <= place.clearance_error + bound
        assert place.point.shape == (3,)
        held = [place.vertex, place.edge, place.face]
        assert sum(number is not None for number in held) <= 1
        for site in place.sites:
            if site.kind == "object":
                away = distances(place.point[None], scene.objects[site.index])[0]
                assert abs(away - place.clearance) <= 2 * place.error + 1e-12
    others = vcell.cell(scene).vertex_clearances
    assert np.all(others >= places.least.clearance - 1e-9) and np.all(others <= places.greatest.clearance + 1e-9)
    bare = vcell.clearance_places(vcell.cell(scene, measure=False))
    assert bare.least is None and bare.greatest is None


def test_parts_keep_what_they_are_of(around_a_ball):
    """References into a cell live on without it: no dangling memory, whatever is dropped first."""
    surface = vcell.cell(around_a_ball).faces[0].patches[0].surface
    curve = vcell.cell(around_a_ball).edges[3].curve
    trim = vcell.cell(around_a_ball).faces[1].patches[0].loops[0][0].curve
    element = vcell.check(vcell.cell(around_a_ball)).elements[0]
    points = vcell.mesh(vcell.cell(around_a_ball)).points
    gc.collect()
    junk = [vcell.cell(around_a_ball) for _ in range(3)]
    again = junk[0]
    assert np.array_equal(surface.control_points, again.faces[0].patches[0].surface.control_points)
    assert np.array_equal(curve.control_points, again.edges[3].curve.control_points)
    assert np.array_equal(trim.control_points, again.faces[1].patches[0].loops[0][0].curve.control_points)
    assert element.where == vcell.check(again).elements[0].where
    assert np.array_equal(points, vcell.mesh(again).points)


def test_curves_evaluate_arrays_of_any_shape(around_a_ball):
    curve = vcell.cell(around_a_ball).edges[0].curve
    a, b = curve.domain
    t = np.linspace(a, b, 6).reshape(2, 3)
    assert curve.evaluate(t).shape == (2, 3, 3) and curve.evaluate(a).shape == (3,)
    assert np.array_equal(curve.evaluate(t)[1, 2], curve.evaluate(b))
    h = 1e-6 * (b - a)
    middle = (a + b) / 2
    difference = (curve.evaluate(middle + h) - curve.evaluate(middle - h)) / (2 * h)
    assert np.allclose(curve.derivative(middle), difference, rtol=1e-5, atol=1e-5)
    assert len(curve.knots) == len(curve.control_points) + curve.degree + 1 == len(curve.weights) + curve.degree + 1


def test_changed_cells_are_the_changed_scene_s(around_a_ball):
    cell = vcell.cell(around_a_ball)
    whole = around_a_ball.objects
    less = vcell.Scene(around_a_ball.base, whole[1:], around_a_ball.box)
    without = vcell.remove(cell, 0)
    assert without.measures.volume == pytest.approx(vcell.cell(less).measures.volume, rel=1e-12)
    back = vcell.insert(without, whole[0])
    assert back.measures.volume == pytest.approx(cell.measures.volume, rel=1e-12)
    half = [vcell.cell(vcell.Scene(around_a_ball.base, part, around_a_ball.box)) for part in (whole[:20], whole[20:])]
    assert vcell.merge(*half).measures.volume == pytest.approx(cell.measures.volume, rel=1e-12)
    assert len(cell.faces) == len(back.faces)  # cells do not change


def test_complete_measures_of_a_plane_are_what_samples_say(balls, rng):
    scene = vcell.Scene(vcell.Plane((5, 5, 0.2), (0.1, 0.2, 1)), balls[balls[:, 2] > 5], [(0, 0, 0), (10, 10, 10)])
    measures = vcell.complete_measures(scene)
    points = rng.uniform(0, 10, (20000, 3))
    above = (points - scene.base.point) @ scene.base.normal >= 0
    nearest = np.min([distances(points, o) for o in scene.objects], axis=0)
    part = (above & (distances(points, scene.base) <= nearest)).mean()
    assert abs(part - measures.volume / 1000) < 5 * np.sqrt(part * (1 - part) / len(points))
    cell = vcell.cell(scene, complete=True)
    assert cell.is_complete
    assert abs(cell.measures.volume - measures.volume) <= cell.measures.volume_error + measures.volume_error
    assert set(measures.neighbors) == set(cell.neighbors)


def test_a_probe_ends_the_cell(balls):
    scene = vcell.Scene(vcell.Sphere((5, 5, 5), 0.5), np.empty((0, 4)), [(0, 0, 0), (10, 10, 10)], probe=1.5)
    cell = vcell.cell(scene)
    assert vcell.check(cell).holds
    assert [str(f.site) for f in cell.faces] == ["cap"] and cell.face_sites.tolist() == [-8]
    assert cell.measures.volume == pytest.approx(4 / 3 * np.pi * 8, rel=1e-12)


def test_trisectors_are_equally_far_from_three():
    three = (vcell.Sphere((0, 0, 0), 0.5), vcell.Sphere((2, 0, 0), 0.2), vcell.Cylinder((0, 2, 0), (1, 0, 1), 0.3))
    found = vcell.trisector(*three, box=[(-3, -3, -3), (3, 3, 3)], tolerance=1e-6)
    assert found
    for curve in found:
        for arc in curve.arcs:
            gaps = [distances(arc.evaluate(np.linspace(*arc.domain, 40)), item) for item in three]
            assert curve.error <= 1e-6 and np.ptp(gaps, axis=0).max() <= 2 * curve.error + 1e-12
    ends = found[0].arcs
    assert all(np.allclose(a.evaluate(a.domain[1]), b.evaluate(b.domain[0])) for a, b in zip(ends, ends[1:]))
    axis = vcell.trisector(*(vcell.Sphere(c) for c in np.eye(3)), box=[(-1, -1.1, -1.2), (1, 1.3, 1.5)], tolerance=1e-6)
    assert [c.kind for c in axis] == ["line"]
    with pytest.raises(ValueError, match="b: two of the objects are the same"):
        vcell.trisector(three[0], three[1], three[1], box=[(0, 0, 0), (1, 1, 1)], tolerance=1e-6)


def test_a_concentric_vessel_leaves_a_ball_half_the_way():
    scene = vcell.Scene(vcell.Sphere((0, 0, 0), 0.5), [vcell.HollowSphere((0, 0, 0), 1.5)],
                        box=[(-2, -2, -2), (2, 2, 2)])
    assert vcell.cell(scene).measures.volume == pytest.approx(4 / 3 * np.pi, rel=1e-9)
    assert repr(scene.objects[0]) == "HollowSphere(center=[0.0, 0.0, 0.0], radius=1.5)"


def test_a_ball_at_the_wall_of_a_hollow_cone():
    cone = vcell.HollowCone((0, 0, -8), (0, 0, 3), 4, 5)
    scene = vcell.Scene(vcell.Sphere((0, 0, 0)), [cone], box=[(-3, -4, -0.125), (3, 4, 12)])
    corners = [v for v in vcell.cell(scene).vertices if v.point[2] > 11]
    assert [v.clearance for v in corners] == pytest.approx([13] * 4, rel=1e-14)
    assert repr(cone) == "HollowCone(apex=[0.0, 0.0, -8.0], axis=[0.0, 0.0, 3.0], radius=4.0, slant=5.0)"


def test_refined_vertices_hold_in_fractions():
    points = [(1, 2, 2), (-2, 1, 2), (0, -3, 1), (1, 1, -3)]
    cell = vcell.cell(vcell.Scene(vcell.Sphere((0, 0, 0)), [vcell.Sphere(p) for p in points], [(-9, -9, -9), (9, 9, 9)]))
    told = 0
    for number, vertex in enumerate(cell.vertices):
        refined = vcell.refine(cell, number, bits=200)
        *place, clearance = refined.bounds
        for (low, high), x in zip(refined.bounds, [*vertex.point, vertex.clearance]):
            assert low <= high and high - low <= Fraction(32, 2**200) and abs(float(low) - x) <= vertex.error
        # Equally far from each of its sites that are objects: 2 p.x = p.p, in rational numbers.
        for site in refined.sites:
            if site.kind == "object":
                p = points[site.index]
                ends = [2 * sum(c * s[c > 0 if side else c <= 0] for c, s in zip(p, place)) for side in (0, 1)]
                assert ends[0] <= sum(c * c for c in p) <= ends[1]
                told += 1
    assert told > 4
    with pytest.raises(IndexError):
        vcell.refine(cell, len(cell.vertices))
    with pytest.raises(ValueError, match="bits"):
        vcell.refine(cell, 0, bits=1000)
