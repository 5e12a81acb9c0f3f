"""Interior: pixels that ask one question, and not two at once."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from fusion.sensor.view import Image, View

EDGE_PX = 5.0  # nearer to a depth edge a tile would mix two questions
SMALL_PX = 100  # width of an image below which all that reaches over pixels reaches over fewer: each sees more
STEEPEST = np.deg2rad(75.0)
PRINT_PX = 2.0  # what a printed edge reaches over
FEW_PX = 16  # width of an image below which every pixel sees several materials: only their mean counts there
PRINT_EDGE = 0.25  # relative change of the amplitude to a neighbour: pixels there see two materials


def reach(px: float, width: int) -> float:
    """How far [px] something of `px` in usual images reaches in one of a width [px]; a pixel or more."""
    return max(1.0, px * min(1.0, width / SMALL_PX))


def interior(view: View) -> NDArray[np.bool_]:
    """(h, w) pixels that see one surface of one material, and not edge-on."""
    inside = np.ones(view.camera.shape, bool)
    if view.edges is not None:
        inside &= view.edges.distance > reach(EDGE_PX, view.camera.width)
    if view.incidence is not None:
        inside &= view.incidence < STEEPEST
    if view.reflectance is not None and view.camera.width >= FEW_PX:
        inside &= ~_printed_edges(view.reflectance)
    return inside


def _printed_edges(reflectance: Image) -> NDArray[np.bool_]:
    """Pixels (h, w) that see, or whose neighbours see, two materials."""
    r = np.nan_to_num(reflectance)
    change = np.zeros(r.shape, bool)
    for axis in (0, 1):
        step = np.abs(np.diff(r, axis=axis)) > PRINT_EDGE * np.maximum(np.delete(r, 0, axis), 0.01)
        change |= np.insert(step, 0, False, axis=axis) | np.insert(step, step.shape[axis], False, axis=axis)
    return np.asarray(binary_dilation(change, iterations=round(reach(PRINT_PX, r.shape[1]))))
