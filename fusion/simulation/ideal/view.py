"""What a sensor's effects ask of an ideal frame: given, computed from the depth, or not to be known."""

from dataclasses import replace

import numpy as np

from fusion.geometry.camera import Camera
from fusion.sensor.edges.nearest import REACH_PX, Indices
from fusion.sensor.effects.optics import OPTICS
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.rig import RIG
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Edges, Image, View, incidence_of
from fusion.simulation.ideal.edges import edges_of_perfect
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.slopes import Facing, facing_of
from fusion.simulation.rendering.edges import JUMP, Between, edges_between

FARTHEST = 5.0  # standard deviations: an edge jitters farther once in some three million draws
NEAR = 0.4  # [m] nearer than that few sensors see: where a jitter in metres is widest in pixels
APERTURE = 1.0  # [px] half the diagonal of a pixel is 0.71
MOVING = (*OPTICS, *RIG)  # rays or surfaces: what a surface then shows, its normal tells
# variable of an effect that no depth image holds: what it is called
UNKNOWN = {
    "velocity": "motion",
    "neighbours": "light that comes by other surfaces",
}


def view_of_ideal(frame: IdealFrame, camera: Camera, sensor: Sensor) -> View:
    """The view (truth) of a checked frame, with no more channels than the sensor's effects ask for."""
    asked = {variable for effect in sensor.effects for variable in effect.variables}
    normals = frame.rows is not None or any(isinstance(effect, MOVING) for effect in sensor.effects)
    facing = _facing(frame, camera, normals)
    view = View(camera, frame.depth, facing.incidence, facing.normals, lit=frame.lit, moment=frame.moment)
    if frame.reflectance is not None:
        filled = np.broadcast_to(np.asarray(frame.reflectance, np.float32), camera.shape)
        view = replace(view, reflectance=filled)
    if "edge" in asked and (reach := reach_of(sensor, camera, _nearest(frame.depth))):
        if frame.rows is not None and facing.normals is not None:
            view = replace(view, edges=edges_within(view, facing.normals, frame, reach))
        else:
            view = replace(view, edges=edges_of_perfect(frame, _light(view, facing.cosine), reach))
    principle = sensor.principle.or_else(camera.principle)
    return replace(view, baseline=sensor.baseline, principle=principle)


def reach_of(sensor: Sensor, camera: Camera, nearest: float = NEAR) -> float:
    """How far from an edge [px] it matters to a sensor's effects where nothing is nearer than so many metres; 0: to
    none.
    """
    reach = 0.0
    for effect in sensor.effects:
        if "edge" not in effect.variables or effect.name == "projector_shadow":  # that looks along rows itself
            continue
        if isinstance(effect, LateralNoise):
            jitter = np.hypot(np.max(effect.sigma_px), np.max(effect.sigma) * camera.fx / nearest)
            reach = max(reach, min(REACH_PX, FARTHEST * float(jitter)))
        elif isinstance(effect, EdgeFattening):
            reach = max(reach, min(REACH_PX, float(np.max(effect.window_px)) / 2 + 0.5))
        else:
            reach = max(reach, APERTURE if effect.name == "mixed_pixels" else REACH_PX)
    return reach


def _nearest(depth: Image) -> float:
    """The least depth of an image [m]: there a jitter in metres is widest in pixels."""
    least = float(np.fmin.reduce(depth, axis=None))
    return max(least, NEAR) if np.isfinite(least) else NEAR


def unknown_to(sensor: Sensor, frame: IdealFrame) -> list[str]:
    """What the sensor's effects would need and a frame does not hold, one sentence each."""
    told = []
    if frame.reflectance is None and (blind := _by(sensor, ("amplitude", "reflectance"))):
        told.append(f"reflectance is not given: what depends on the light that returns is left out ({blind})")
    for variable, name in UNKNOWN.items():
        if blind := _by(sensor, (variable,)):
            told.append(f"{name} cannot be known from depth: left out ({blind})")
    if sensor.effect("temperature_drift") is not None and not frame.moment.time:
        told.append("time since switch-on is not known: the first frame counts as switched on now (temperature_drift)")
    if frame.rows is None and _by(sensor, ("edge",)) and reach_of(sensor, Camera(1, 1, 500.0, 500.0, 0.0, 0.0)):
        told.append("where between two pixels an edge runs cannot be known: drawn")
    if frame.lit is None and sensor.effect("projector_shadow") is not None:
        told.append("shadows of things outside the picture cannot be known: those within it are cast")
    return told


def _by(sensor: Sensor, variables: tuple[str, ...]) -> str:
    """Names of the effects that depend on one of these variables."""
    named = (effect for effect in sensor.effects if set(variables) & set(effect.variables))
    return ", ".join(e.name for e in named if not (isinstance(e, AxialNoise) and not np.any(e.ir_reference)))


def _facing(frame: IdealFrame, camera: Camera, normals: bool) -> Facing:
    """As the normals given say, else the depth."""
    if frame.normals is None:
        return facing_of(frame.depth, camera, frame.rounding, normals)
    with np.errstate(all="ignore"):
        given = np.asarray(frame.normals, np.float32)
        given = given / np.linalg.norm(given, axis=-1, keepdims=True)
        rays = camera.rays()
        away = given[..., 0] * rays[..., 0] + given[..., 1] * rays[..., 1] + given[..., 2] > 0
        given = np.where(away[..., None], -given, given)
        incidence = incidence_of(given, camera)
        return Facing(incidence, np.cos(incidence), given)


def _light(view: View, cosine: Image) -> Image:
    """(h, w) what comes back of a lamp at the camera, in any unit."""
    assert view.depth is not None
    with np.errstate(all="ignore"):
        reach = view.depth * view.stretch
        light = cosine / (reach * reach)
        return light if view.reflectance is None else light * np.nan_to_num(view.reflectance)


def edges_within(view: View, flat: Image, frame: IdealFrame, reach: float = REACH_PX) -> Edges:
    """The nearest edge of every pixel of the view of a checked frame that has rows and columns.

    Images n times as fine along rows, and along columns, have n - 1 values more between two pixels; a renderer makes
    them with a camera of n fx (or n fy). With 64 edges are where the own simulator bisects them to.

    Args:
        view: with depth, incidence and, where it is known, reflectance.
        flat: (h, w, 3) normals, towards the camera.
        reach: farther edges are none [px].
    """
    with np.errstate(all="ignore"):
        return edges_between(view, flat, _between(frame, view.camera.width), reach)


def _between(frame: IdealFrame, width: int) -> Between:
    """Depth between neighbours: along the surface of the value before or after."""
    assert frame.rows is not None and frame.columns is not None
    rows, columns = 1 / frame.rows, 1 / frame.columns
    finer = rows.shape[1] // width

    def sampled(first: Indices, second: Indices, share: Image, ray: Image) -> Image:
        v, u = np.divmod(first, width)
        step = np.minimum((share * finer).astype(np.intp), finer - 1)
        part, step = (share * finer - step).astype(np.float32), step + finer // 2
        right = second == first + 1
        found = np.empty(len(first), np.float32)
        found[right] = _along(rows, v[right], (u * finer + step)[right], part[right])
        found[~right] = _along(columns.T, u[~right], (v * finer + step)[~right], part[~right])
        return found

    return sampled


def _along(inverse: Image, line: Indices, at: Indices, part: Image) -> Image:
    """Depth (n,) [m] a `part` of the way from the values `at` (n,) of lines (n,) to the next ones.

    Where neither side's slope leads to the other value, an edge runs between: half way, as far as is known.
    """
    own, other = inverse[line, at], inverse[line, at + 1]
    step = other - own
    before = own - inverse[line, np.maximum(at - 1, 0)]
    after = inverse[line, np.minimum(at + 2, inverse.shape[1] - 1)] - other
    # a slope that leads over an edge itself is none
    before, after = (np.where(np.abs(slope) < np.abs(step), slope, 0) for slope in (before, after))
    smooth = np.fmin(np.abs(step - before), np.abs(step - after)) <= JUMP * np.fmax(own, other)
    torn = np.where(part < 0.5, own + part * before, other - (1 - part) * after)
    return np.asarray(1 / np.where(smooth, own + part * step, torn), np.float32)
