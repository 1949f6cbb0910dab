"""Scenes: what goes in comes out, and what is wrong is named."""
import pickle

import numpy as np
import pytest

import vcell

box = vcell.Box((-1, -1, 0), (1, 1, 2))
floor = vcell.Plane((0, 0, 0), (0, 0, 1))


def test_objects_keep_their_numbers():
    tube = vcell.Cylinder(point=[1, 2, 3], axis=np.array([0, 0, 2]), radius=0.5)
    assert tube.point.tolist() == [1, 2, 3] and tube.axis.tolist() == [0, 0, 2] and tube.radius == 0.5
    assert tube == vcell.Cylinder((1, 2, 3), (0, 0, 2), 0.5) and tube != floor
    assert repr(vcell.Sphere((0, 0, 1), 0.25)) == "Sphere(center=[0.0, 0.0, 1.0], radius=0.25)"
    tube.point[0] = 7  # an array of its own
    assert tube.point[0] == 1


def test_scenes_are_values():
    scene = vcell.Scene(floor, [vcell.Sphere((0, 0, 1), 0.25)], box, names=["A"], units="um", tolerance=1e-5)
    assert scene.base == floor and scene.objects == [vcell.Sphere((0, 0, 1), 0.25)]
    assert (scene.names, scene.units, scene.tolerance, scene.base_object) == (["A"], "um", 1e-5, None)
    for other in (vcell.parse_scene(scene.to_json()), pickle.loads(pickle.dumps(scene))):
        assert other.objects == scene.objects and other.base == floor and other.names == ["A"]
        assert np.array_equal(other.box.max, box.max)


def test_balls_come_as_an_array():
    rows = np.array([[0, 0, 1, 0.25], [0.5, 0, 1, 0]])
    scene = vcell.Scene(floor, rows, [(-1, -1, 0), (1, 1, 2)])
    assert scene.objects == [vcell.Sphere((0, 0, 1), 0.25), vcell.Sphere((0.5, 0, 1), 0)]


@pytest.mark.parametrize("make, path, kind", [
    (lambda: vcell.Scene(floor, [vcell.Sphere((0, 0, 1), 0.1), vcell.Sphere((0, 0, 1), -1)], box),
     "objects[1].sphere.radius", "negative radius"),
    (lambda: vcell.Scene(floor, [vcell.Sphere((0, np.nan, 1), 0)], box), "objects[0].sphere.center[1]", "not finite"),
    (lambda: vcell.Scene(vcell.Plane((0, 0, 0), (0, 0, 0)), [], box), "base.plane.normal", "zero axis"),
    (lambda: vcell.Scene(floor, [], [(0, 0, 0), (1, 0, 1)]), "box", "empty box"),
])
def test_bad_input_is_a_value_error_that_names_its_place(make, path, kind):
    with pytest.raises(ValueError) as caught:
        make()
    assert isinstance(caught.value, vcell.InputError)
    assert caught.value.path.startswith(path) and caught.value.kind == kind
    assert str(caught.value).startswith(caught.value.path + ": ")


def test_an_object_that_touches_the_base_is_named():
    with pytest.raises(vcell.InputError) as caught:
        vcell.cell(vcell.Scene(floor, [vcell.Sphere((0, 0, 1), 0.1), vcell.Sphere((0, 0, 0.5), 0.5)], box))
    assert caught.value.object == 1 and caught.value.kind == "touches base"


@pytest.mark.parametrize("make, message", [
    (lambda: vcell.Sphere((0, 1), 0), r"center: must have shape \(3,\), has \(2,\)"),
    (lambda: vcell.Sphere("abc", 0), "center: must be numbers"),
    (lambda: vcell.Scene(floor, np.zeros((4, 3)), box), r"objects: must have shape \(n, 4\), has \(4, 3\)"),
    (lambda: vcell.Scene(floor, [], (0, 1)), "box: must be a Box or have shape"),
    (lambda: vcell.Scene(floor, [vcell.Sphere((0, 0, 1))], box, names=["A", "B"]), "names: must be one"),
])
def test_arrays_of_the_wrong_shape_are_value_errors(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_objects_of_another_type_are_named():
    with pytest.raises(TypeError, match=r"objects\[1\]: must be a Plane, a Sphere, a Cylinder or a vessel"):
        vcell.Scene(floor, [vcell.Sphere((0, 0, 1)), box], box)


def test_files(data, tmp_path):
    with pytest.raises(OSError):
        vcell.read_scene(tmp_path / "absent.json")
    with pytest.raises(vcell.InputError) as caught:
        vcell.parse_scene('{"vcell": 1, "base": {"spher": {}}}')
    assert caught.value.path == "base.spher"
    atom = vcell.read_scene(data / "1CRN.xyzr", base_ball=7)
    assert atom.base_object == 7 and len(atom.objects) == 327
