"""What blur does to a bent surface: it moves inwards where that is convex, and outwards where it is hollow."""

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.mesh import Mesh

Array = NDArray[np.float64]


def bend(mesh: Mesh) -> Array:
    """Sum of both curvatures (n,) [1/m], positive where convex; 0 at vertices without an edge.

    Along an edge the curvature is how much the normal turns per length; twice its mean over the edges is the sum of
    both (Euler 1760, averaged over directions).
    """
    assert mesh.normals is not None
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    a, b = edges.T
    way = mesh.vertices[b] - mesh.vertices[a]
    turned = mesh.normals[b].astype(float) - mesh.normals[a]
    along = np.einsum("ij,ij->i", turned, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-12)
    n = len(mesh.vertices)
    count = np.bincount(a, minlength=n) + np.bincount(b, minlength=n)
    total = np.bincount(a, along, n) + np.bincount(b, along, n)
    return np.asarray(2 * total / np.maximum(count, 1))


def moved_by_blur(curvature: Array, blur: Array | float) -> Array:
    """How far [m] a normal blur of standard deviation `blur` [m] moves a surface of that sum of curvatures [1/m].

    A height field z, blurred, changes by blur^2 / 2 times its Laplacian (the heat equation, to first order); where the
    surface bends within the blur it cannot move by more than the blur itself.
    """
    return np.asarray(np.minimum(np.abs(curvature) * np.square(blur) / 2, blur))
