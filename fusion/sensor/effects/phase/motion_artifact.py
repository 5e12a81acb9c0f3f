"""Motion artifact: the four phase images of a frame are taken one after another, while what is seen moves on."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.laws.phasor import turn
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

STEPS = np.arange(4)


@dataclass(frozen=True)
class MotionArtifact(Effect):
    """Four exposures of duration / 4 each, the frame's time in the middle; nothing where velocities are not known.

    Q_k = A_k cos(phase_k - k pi/2), range from atan2(Q_1 - Q_3, Q_0 - Q_2). Towards the camera, phase_k moves on by
    the velocity: the range changes by about v duration / 8 cos(2 phase). Sideways, a pixel that an edge
    passes meanwhile sees one side in some of the exposures and the other side in the rest.
    """

    name: ClassVar[str] = "motion_artifact"
    key: ClassVar[str] = "I9"
    formula: ClassVar[str] = "range_measured = range + v_radial duration / 8 cos(2 phase); both sides mixed at edges"
    variables: ClassVar[tuple[str, ...]] = ("velocity", "edge", "range")
    per_frequency: ClassVar[bool] = True
    principles: ClassVar[tuple[Principle, ...]] = (Principle.TIME_OF_FLIGHT,)
    not_corrected: ClassVar[str] = "one depth image does not tell velocities"

    duration: Value = parameter(
        "s", (0, 0.2), "of all four exposures together", "four phase steps, derived; 125 ms: Drayton 2013", typical=0.02
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.velocity is None or not np.any(self.duration):
            return np.zeros((), depth.dtype)
        duration, rays = float(np.mean(self.duration)), view.camera.rays()
        velocity = np.asarray(view.velocity, depth.dtype)
        away = np.nan_to_num(velocity[..., 0] * rays[..., 0] + velocity[..., 1] * rays[..., 1] + velocity[..., 2])
        phase = turn(view) * depth * view.stretch
        # Q_1 - Q_3 is the sine of a phase `late` ahead, Q_0 - Q_2 the cosine of one `late` behind: half a step each
        late = turn(view) * (duration / 8.0) * away / view.stretch
        sine, twice = np.sin(late), 2.0 * phase
        change = np.arctan2(sine * np.cos(twice), np.cos(late) + sine * np.sin(twice))
        if view.edges is not None:
            edges = view.edges
            near = np.flatnonzero(np.isfinite(edges.distance + edges.direction + edges.jump + edges.light))
            shares = passed(near, depth, velocity, duration, view)
            cut = np.flatnonzero(shares.any(axis=0))  # pixels that an edge reaches
            change.flat[near[cut]] = _mixed(near[cut], shares[:, cut], phase, view)
        return change / (turn(view) * view.stretch)


def passed(where: np.ndarray, depth: Image, velocity: Image, duration: float, view: View) -> Image:
    """Share (4, n) of each exposure in which these pixels (flat indices) see the other side of their edge."""
    assert view.edges is not None
    camera, edges = view.camera, view.edges
    v, u = np.divmod(where, camera.width)
    direction, distance = edges.direction.ravel()[where], np.maximum(edges.distance.ravel()[where], 1e-3)
    jump = edges.jump.ravel()[where]
    # an edge moves with the nearer of its two sides; the other side begins one pixel beyond it
    beyond = jump < 0
    reach = np.where(beyond, distance + 1.0, 0.0)
    u_near = np.clip(np.rint(u + reach * np.cos(direction)), 0, camera.width - 1).astype(np.intp)
    v_near = np.clip(np.rint(v + reach * np.sin(direction)), 0, camera.height - 1).astype(np.intp)
    speed = velocity[v_near, u_near]
    z = depth.ravel()[where] + np.where(beyond, jump, 0.0)
    along_u = (camera.fx * speed[:, 0] - (u - camera.cx) * speed[:, 2]) / z
    along_v = (camera.fy * speed[:, 1] - (v - camera.cy) * speed[:, 2]) / z
    coming = -(along_u * np.cos(direction) + along_v * np.sin(direction))  # [px/s] towards the pixel
    when = distance / np.where(np.abs(coming) > 1e-6, coming, 1e-6)  # [s], negative when it has passed
    end = (STEPS[:, None] - 1.0) * (duration / 4.0)  # of each exposure, from the middle of the frame
    after = np.clip((end - when) / (duration / 4.0), 0.0, 1.0)
    return np.nan_to_num(np.where(when > 0, after, 1.0 - after))


def _mixed(where: np.ndarray, shares: Image, phase: Image, view: View) -> Image:
    """Change of the phase (n,) when the exposures see these shares of the other side."""
    assert view.edges is not None
    own, ratio = phase.ravel()[where], view.edges.light.ravel()[where]
    other = own + turn(view) * view.edges.jump.ravel()[where] * view.stretch.ravel()[where]
    step = STEPS[:, None] * (np.pi / 2.0)
    q = (1.0 - shares) * np.cos(own - step) + shares * ratio * np.cos(other - step)
    along, across = q[0] - q[2], q[1] - q[3]
    # the angle between the phasor seen and the own one
    return np.arctan2(across * np.cos(own) - along * np.sin(own), along * np.cos(own) + across * np.sin(own))
