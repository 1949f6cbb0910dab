"""Exact Voronoi cells of planes, spheres and cylinders.

cell(scene) is the Voronoi cell of a scene's base among its objects, as trimmed rational patches; diagram(scene) has the
cells of all objects. query(scene, points) tells whose points are, check(cell) proves a cell from its own data, mesh(cell)
makes triangles, write(cell, path) files.

Lengths are in the unit of the scene, points are rows of arrays of doubles of shape (n, 3), and every `..._error` is a proven
bound unless `is_estimated` says otherwise. Sites are numbered in arrays: objects by their place in the scene, sides of the
box -1 ... -6 (-x +x -y +y -z +z), the base and its ends -7, the cap at a probe's distance -8, and NO_SITE where there is none.
"""
import numpy  # noqa: F401  results are its arrays: a Python without it is told here

from ._vcell import *  # noqa: F401,F403
from ._vcell import __version__  # noqa: F401
