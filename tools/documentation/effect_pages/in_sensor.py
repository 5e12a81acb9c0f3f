"""Pictures of the effects of triangulation, phase and readout."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.moment import Moment
from fusion.sensor.view import View
from tools.documentation.effect_pages.before_sensor import (
    DEPTH,
    DEPTH_LABEL,
    EDGE_NOTE,
    MOVING_EDGE,
    RANGE_LABEL,
    drifting,
)
from tools.documentation.effect_pages.panel import Panel, Picture, across_edge, change, image, sweep
from tools.documentation.effect_pages.views import FLIGHT, FX, Seen, at, beside_edge, one, pixel, wall

COLUMN = np.arange(0.0, 640.0, 8)
IR_LABEL = "amplitude [count]"
NODES = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0])
FAR_AWAY = np.linspace(0.05, 6.0, 596)
MEASURED = np.array([0.006, -0.002, -0.004, 0.003, 0.005, -0.003, -0.001])
TINY = (slice(225, 255), slice(300, 340))
SMALL = (slice(217, 262), slice(290, 350))  # part of an image in which each pixel counts


def column(depth: float, principle: Principle, note: str, **more: object) -> Panel:
    """Over the columns of an image of 640 px of a frontal wall."""
    return sweep("bias", COLUMN, "column [px]", lambda u: pixel(Seen(depth, (u - 319.5) / FX), principle, **more), note)


def bright(count: float, principle: Principle = FLIGHT) -> View:
    return at(2.0, principle, ir=one(count))


def striped() -> View:
    """A bright stripe on a dark wall that is turned away: the phase changes from pixel to pixel."""
    view = wall(1.5, np.deg2rad(50), FLIGHT)
    bright = (view.u > 308) & (view.u < 332)
    return replace(view, ir=np.where(bright, 1000.0, 50.0) * np.ones(view.camera.shape))


def wrapped(effect: Effect) -> NDArray[np.floating]:
    return np.array([z + float(change(effect, at(z, FLIGHT), "bias")[0, 0]) for z in FAR_AWAY])


def behind(count: NDArray[np.floating], effect: Effect) -> NDArray[np.floating]:
    return np.array([float(effect.light(one(a), one(2.0), bright(a))[0, 0]) for a in count])


def after_jump(effect: Effect) -> NDArray[np.floating]:
    """What is left of a jump of 10 cm, frame by frame."""
    left = [0.1]
    for _ in range(12):
        view = at(2.0, moment=Moment(previous=one(2.0 + left[-1])))
        left.append(float(change(effect, view, "bias")[0, 0]))
    return np.array(left)


def settling(effect: Effect) -> NDArray[np.floating]:
    """Spread of each frame after the start, of 3 mm in front: only the first frame has none before it."""
    frames, own = [0.003], 0.003
    new = float(effect.spread(one(own), one(2.0), at(2.0, moment=Moment(previous=one(2.0))))[0, 0]) / own
    for _ in range(12):
        frames.append(float(np.hypot(new * own, (1.0 - new) * frames[-1])))
    return np.array(frames)


def warm(depth: float, degrees: float, time: float) -> View:
    return at(depth, FLIGHT, moment=Moment(time=time, temperature=degrees))


IN_SENSOR: dict[str, Picture] = {
    "edge_fattening": Picture((across_edge("bias", beside_edge, EDGE_NOTE),), ("window_px",)),
    "projector_thermal_drift": Picture(
        (column(2.0, Principle.STRUCTURED_LIGHT, "frontal wall at 2 m, 10 K warmer", moment=Moment(temperature=35.0)),),
        ("coefficient",),
    ),
    "disparity_offset": Picture((sweep("bias", DEPTH, DEPTH_LABEL, at, "fx b = 43.5 px m"),), ("offset",)),
    "disparity_distortion": Picture(
        (image("bias", wall, "a warp that one unit keeps, wall at 2 m"),), ("rms",), ("rms",)
    ),
    "speckle_noise": Picture(
        (
            image("bias", wall, "a part of a wall at 2 m", SMALL),
            sweep("noise", DEPTH, DEPTH_LABEL, at, "between placements"),
        ),
        ("sigma_px",),
    ),
    "pixel_locking": Picture(
        (sweep("bias", np.linspace(1.5, 3.5, 401), DEPTH_LABEL, at, "fx b = 43.5 px m"),), ("amplitude",)
    ),
    "vertical_banding": Picture(
        (image("bias", wall, "columns that one unit keeps, wall at 2 m", steps=True),), ("step",), ("step",)
    ),
    "emitter_parallax": Picture(
        (
            sweep(
                "bias",
                np.linspace(0.3, 4.0, 149),
                RANGE_LABEL,
                lambda z: at(z, FLIGHT),
                "middle of the image",
            ),
            column(1.0, FLIGHT, "frontal wall at 1 m"),
        ),
        ("baseline",),
    ),
    "mixed_pixels": Picture((across_edge("bias", lambda s: beside_edge(s, FLIGHT), EDGE_NOTE, 1.5),), ("fill",)),
    "pixel_crosstalk": Picture(
        (image("bias", striped, "bright stripe, dark wall tilted by 50 deg", TINY, steps=True),), ("fraction",)
    ),
    "sensor_interference": Picture(
        (
            sweep(
                "bias",
                np.linspace(0, 20, 201),
                "time [s]",
                lambda t: at(2.0, FLIGHT, moment=Moment(time=t)),
                "slow beat of 0.1 Hz",
            ),
            sweep("noise", np.geomspace(50, 3000, 101), IR_LABEL, bright, "wall at 2 m", log=True),
        ),
        ("fraction",),
    ),
    "motion_artifact": Picture(
        (
            sweep(
                "bias",
                np.linspace(0.5, 3.0, 251),
                RANGE_LABEL,
                lambda z: at(z, FLIGHT, velocity=drifting(0, 0, 0.5)),
                "moves away at 0.5 m/s",
            ),
            across_edge("bias", lambda s: beside_edge(s, FLIGHT, velocity=drifting(0.5, 0, 0)), MOVING_EDGE),
        ),
        ("duration",),
    ),
    "cyclic_error": Picture(
        (
            sweep(
                "bias",
                np.linspace(0.5, 3.0, 251),
                RANGE_LABEL,
                lambda z: at(z, FLIGHT),
                "one harmonic, period 0.469 m",
            ),
        ),
        ("amplitude",),
    ),
    "amplitude_error": Picture(
        (sweep("bias", np.geomspace(50, 5000, 121), IR_LABEL, bright, "any range, middle of the image", log=True),),
        ("coefficient",),
    ),
    "column_delay": Picture((image("bias", lambda: wall(principle=FLIGHT), "any range"),), ("slope", "slope_v")),
    "phase_wrapping": Picture(
        (
            Panel(
                "bias",
                FAR_AWAY,
                "true range [m]",
                wrapped,
                "one frequency: 80 MHz, or twice that",
                ("measured range [m]", 1.0),
            ),
        ),
        ("range",),
    ),
    "lateral_noise": Picture(
        (
            across_edge("noise", beside_edge, EDGE_NOTE),
            across_edge("bias", beside_edge, "mean over many frames"),
        ),
        ("sigma_px", "sigma"),
    ),
    "fixed_pattern": Picture(
        (image("bias", wall, "a part of the image of one unit", TINY, steps=True),), ("rms",), ("rms",)
    ),
    "temperature_drift": Picture(
        (
            sweep(
                "bias", np.linspace(15, 45, 61), "temperature [degC]", lambda t: warm(2.0, t, 0.0), "change per kelvin"
            ),
            sweep(
                "bias",
                np.linspace(0, 60, 121),
                "time since switching on [min]",
                lambda t: warm(2.0, 25.0, 60 * t),
                "warming up",
            ),
        ),
        ("coefficient", "amplitude"),
        ("coefficient", "amplitude"),
    ),
    "depth_scale": Picture((sweep("bias", np.linspace(0, 4, 81), DEPTH_LABEL, at),), ("scale",)),
    "depth_offset": Picture(
        (
            sweep("bias", np.linspace(0, 4, 81), DEPTH_LABEL, at, "triangulation"),
            column(2.0, FLIGHT, "time of flight"),
        ),
        ("offset",),
    ),
    "tabulated": Picture(
        (sweep("bias", DEPTH, DEPTH_LABEL, at, "a made-up table over the depth"),),
        ("values",),
        make=lambda factor: Tabulated(("depth",), (tuple(NODES),), factor * MEASURED),
    ),
    "saturation": Picture(
        (
            sweep("dropout", np.linspace(0, 1500, 301), IR_LABEL, bright),
            Panel(
                "light",
                np.linspace(0, 1500, 301),
                "amplitude that arrives [count]",
                lambda e: behind(np.linspace(0, 1500, 301), e),
                label=("amplitude measured [count]", 1.0),
            ),
        ),
        ("ir_threshold",),
    ),
    "amplitude_dropout": Picture(
        (sweep("dropout", np.linspace(0, 80, 161), IR_LABEL, bright),), ("ir_threshold", "width")
    ),
    "axial_noise": Picture(
        (
            sweep("noise", DEPTH, DEPTH_LABEL, at, "c0, c1, c2: frontal wall"),
            sweep(
                "noise",
                np.linspace(0, 80, 161),
                "incidence [deg]",
                lambda a: pixel(Seen(tilt=np.deg2rad(a))),
                "angle, at 2 m",
            ),
            sweep("noise", np.geomspace(100, 5000, 101), IR_LABEL, bright, "shot and floor: by the light", log=True),
        ),
        ("c0", "c1", "c2", "angle", "shot", "floor"),
        ("c0", "c1", "c2", "angle", "angle_exponent", "shot", "floor", "ir_reference"),
    ),
    "temporal_filtering": Picture(
        (
            Panel(
                "bias",
                np.arange(13.0),
                "frames after the jump",
                after_jump,
                "the depth jumps by 10 cm",
                label=("still wrong by [mm]", 1000.0),
            ),
            Panel("noise", np.arange(13.0), "frames since the first", settling, "noise of 3 mm in front"),
        ),
        ("memory",),
    ),
    "depth_quantization": Picture(
        (sweep("bias", np.linspace(1.95, 2.05, 801), DEPTH_LABEL, at, "steps of disparity, fx b = 43.5 px m"),),
        ("step_px",),
        ("step_px",),
    ),
}
