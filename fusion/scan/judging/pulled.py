"""How far the poses pull the surface: pairs of views are asked once more, where the finished motion has them.

One step of the joint fit, each view free to turn and to be moved across the axis, says how the views would rather lie.
Each place of the surface is the mean of the views that saw it, so it follows them by their shares; what is left once
the whole is laid on itself is what the poses bend, and compares with what noise alone leaves.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.certainty.looks import PlacedFrame, look
from fusion.geometry import pose
from fusion.mesh.mesh import Mesh
from fusion.recording.ahead import side_by_side
from fusion.turntable.all_views.joint import WORST, Free, State, fit_jointly
from fusion.turntable.all_views.loop import choose_edges
from fusion.turntable.all_views.together import WIDEST
from fusion.turntable.axis import about_axis
from fusion.turntable.guess.decided import JOINT, POINTS_JOINT
from fusion.turntable.motion import Motion
from fusion.turntable.pairs.edges import CLEAR, FEWEST, above, stack
from fusion.turntable.views import ObjectView, Region, usable, view
from fusion.volume.prepared import Prepared

Array = NDArray[np.float64]
VERTICES = 3000  # that tell an rms to two percent


@dataclass(frozen=True)
class Pulled:
    """What pairs of views say of the finished motion."""

    surface: float  # rms over the surface of what the poses that pairs ask for would move it by, laid on itself [m]
    unfit: float  # share of the pairs, which should show the same surface, that do not fit each other


def pulled(
    mesh: Mesh, frames: list[Prepared | None], poses: Array, motion: Motion, region: Region, near: float
) -> Pulled | None:
    """Ask pairs of views that overlap; None where there are none.

    Args:
        mesh: of the object, with normals.
        frames: (n) cut to the window of the region.
        poses: (n, 4, 4) `T_object_camera`, NaN where a frame has no place.
        motion: that they come from.
        region: where the object is; its images cut to the same window.
        near: truncation of the volume [m].
    """
    shown = [(k, f) for k, f in enumerate(frames) if f is not None and np.isfinite(poses[k]).all()]
    placed = [k for k, _ in shown]
    pairs = choose_edges(motion.angles[placed], WIDEST)
    if not pairs:
        return None
    edges = [*pairs, *((j, i) for i, j in pairs)]  # what one sees and the other looks through tells too
    late = motion.print_contradicts

    def view_of(frame: Prepared) -> ObjectView:
        return view(frame.surface, usable(frame.surface, region), None if late else frame.color)

    views = _above_plate(side_by_side(view_of, (f for _, f in shown)), motion)
    shifts = np.zeros((len(placed), 2)) if motion.shifts is None else motion.shifts[placed]
    state = State(motion.axis, motion.angles[placed], shifts)
    asked = fit_jointly(stack(views), state, edges, JOINT[-1:], Free(1.0), iterations=1)
    # what moves all views alike is the axis, of which the model of all tells more than pairs
    moved = asked.state.shifts - np.mean(asked.state.shifts - shifts, axis=0)
    before = about_axis(motion.axis, state.angles, shifts)
    steps = about_axis(motion.axis, asked.state.angles, moved) @ pose.inverse(before)
    tells = asked.at.visible > 2 * FEWEST
    unfit = float(np.mean(asked.at.misfit[tells] > WORST)) if tells.any() else 0.0
    return Pulled(_bent(mesh, [PlacedFrame(f, poses[k]) for k, f in shown], steps, near), unfit)


def _above_plate(views: list[ObjectView], motion: Motion) -> list[ObjectView]:
    floor = -np.inf if motion.plate is None else motion.plate + CLEAR
    clear = [above(v, motion.axis, floor, POINTS_JOINT) for v in views]
    few = np.median([len(v.points) for v in clear]) < FEWEST
    return [above(v, motion.axis, -np.inf, POINTS_JOINT) for v in views] if few else clear


def _bent(mesh: Mesh, shown: list[PlacedFrame], steps: Array, near: float) -> float:
    """Root mean square [m] along the normals of what steps (k, 4, 4) of views do to the mesh beside a rigid motion."""
    assert mesh.normals is not None
    some = np.unique(np.linspace(0, len(mesh.vertices) - 1, VERTICES).astype(np.intp))
    points, normals = mesh.vertices[some].astype(float), mesh.normals[some].astype(float)
    share = look(Mesh(points, normals=mesh.normals[some]), shown, near).share()
    along = [np.sum((pose.transform(T, points) - points) * normals, axis=1) for T in steps]
    known = share.sum(axis=1) > 0
    if not known.any():
        return 0.0
    lever = np.hstack([np.cross(points, normals), normals])[known]
    moved = np.einsum("mk,km->m", share, np.array(along))[known]
    rest = moved - lever @ np.linalg.lstsq(lever, moved, rcond=None)[0]
    return float(np.sqrt(np.mean(rest**2)))
