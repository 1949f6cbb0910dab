"""Fixtures of the tests: the folder of test data, and random scenes that are the same every time."""
import os
import pathlib

import numpy as np
import pytest

import vcell


@pytest.fixture
def data():
    return pathlib.Path(os.environ.get("VCELL_TEST_DATA", pathlib.Path(__file__).parents[2] / "tests/data"))


@pytest.fixture
def rng():
    return np.random.default_rng(20090811)


@pytest.fixture
def balls(rng):
    """40 balls of different radii in a box of edge 10, rows x, y, z, r, none of them in another one."""
    rows = []
    while len(rows) < 40:
        x, y, z, r = *rng.uniform(1, 9, 3), rng.uniform(0.2, 0.7)
        if all(np.linalg.norm(np.subtract((x, y, z), q[:3])) > r + q[3] for q in rows):
            rows.append((x, y, z, r))
    return np.array(rows)


@pytest.fixture
def around_a_ball(balls):
    """The first ball among all of them."""
    return vcell.Scene(vcell.Sphere(balls[0, :3], balls[0, 3]), balls[1:], [(0, 0, 0), (10, 10, 10)])


def distances(points, item):
    """Of points, shape (n, 3), from an object's surface; negative inside a ball or a cylinder."""
    points = np.asarray(points)
    if isinstance(item, vcell.Plane):
        n = item.normal / np.linalg.norm(item.normal)
        return np.abs((points - item.point) @ n)
    if isinstance(item, vcell.Sphere):
        return np.linalg.norm(points - item.center, axis=-1) - item.radius
    axis = item.axis / np.linalg.norm(item.axis)
    along = (points - item.point) @ axis
    return np.linalg.norm(points - item.point - along[..., None] * axis, axis=-1) - item.radius


def box_distances(points, box):
    """Of points inside a box from its sides -x +x -y +y -z +z: shape (..., 6)."""
    return np.stack([points - box.min, box.max - points], axis=-1).reshape(*points.shape[:-1], 6)
