"""Pictures of the effects of rig, optics and light."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.moment import Moment
from fusion.sensor.view import Indirect, View
from tools.documentation.effect_pages.panel import Panel, Picture, across_edge, change, image, sweep
from tools.documentation.effect_pages.views import (
    CARD,
    FLIGHT,
    FX,
    Seen,
    at,
    beside_edge,
    card_before_wall,
    on_table,
    one,
    pixel,
    wall,
)

TURN = np.linspace(0.0, 360.0, 181)
EDGE_NOTE = "an edge at 1.5 m before a wall at 2 m"
MOVING_EDGE = "the near side moves at 0.5 m/s to the right"
RADIUS = np.linspace(0.0, 400.0, 101)
DEPTH = np.linspace(0.5, 4.0, 141)
DEPTH_LABEL = "depth [m]"
RANGE_LABEL = "range [m]"
TABLE_LABEL = "angle of the table [deg]"
AROUND_CARD = (slice(120, 360, 2), slice(130, 450, 2))  # the part of an image around the card
FRONT, SIDE, RIM = (0.08, 0.0, 0.05), (0.02, 0.1, 0.05), (0.12, 0.0, 0.0)


def table(place: tuple[float, float, float], normal: tuple[float, float, float], note: str) -> Panel:
    return sweep("bias", TURN, TABLE_LABEL, lambda a: on_table(place, normal, np.deg2rad(a)), note)


def tilted(radians: float) -> View:
    """A wall turned by an angle, seen in the middle of the image."""
    return pixel(Seen(tilt=radians))


def drifting(x: float, y: float, z: float) -> NDArray[np.floating]:
    return np.array([[[x, y, z]]])


def rows_of_moving_wall(effect: Effect) -> NDArray[np.floating]:
    view = wall()
    velocity = np.broadcast_to([0.0, 0.0, 0.2], (*view.camera.shape, 3))
    return change(effect, replace(view, velocity=velocity), "bias")[:, 0]


def vignetted() -> View:
    return wall(principle=FLIGHT)


def lit(lux: float, depth: float, principle: Principle = FLIGHT) -> View:
    return at(depth, principle, reflectance=one(0.8), moment=Moment(ambient=lux))


BEFORE_SENSOR: dict[str, Picture] = {
    "turntable_encoder_error": Picture(
        (table(SIDE, (0.7, 0.7, 0.0), "a side of the object, 10 cm beside the axis"),), ("amplitude",)
    ),
    "turntable_eccentricity": Picture(
        (table(FRONT, (1.0, 0.0, 0.0), "the object's side towards the camera"),), ("offset",)
    ),
    "turntable_wobble": Picture(
        (table(RIM, (0.0, 0.0, 1.0), "the plate, 12 cm before its axis, seen 30 deg from above"),), ("tilt",)
    ),
    "pose_jitter": Picture(
        (
            sweep(
                "noise",
                np.linspace(0, 80, 161),
                "incidence [deg]",
                lambda a: tilted(np.deg2rad(a)),
                "at 2 m, middle of the image",
            ),
            sweep("noise", DEPTH, DEPTH_LABEL, lambda z: pixel(Seen(z, 0.4)), "frontal wall, 230 px from the middle"),
        ),
        ("sigma_m", "sigma_rad"),
    ),
    "timestamp_offset": Picture(
        (
            sweep(
                "bias",
                np.linspace(-0.5, 0.5, 51),
                "velocity away from the camera [m/s]",
                lambda s: at(1.0, velocity=drifting(0, 0, s)),
                "a frontal surface",
            ),
            sweep(
                "bias",
                np.linspace(-60, 60, 121),
                "tilt of the wall [deg]",
                lambda a: pixel(Seen(tilt=np.deg2rad(a)), velocity=drifting(0.2, 0, 0)),
                "a wall that moves to the right at 0.2 m/s",
            ),
        ),
        ("offset",),
    ),
    "rolling_shutter": Picture(
        (Panel("bias", np.arange(480.0), "row [px]", rows_of_moving_wall, "a wall that moves away at 0.2 m/s"),),
        ("line_time",),
    ),
    "motion_blur": Picture(
        (across_edge("bias", lambda s: beside_edge(s, velocity=drifting(0.5, 0, 0)), MOVING_EDGE),),
        ("shutter",),
    ),
    "refraction": Picture(
        (
            sweep(
                "bias",
                RADIUS,
                "distance to the image's middle [px]",
                lambda r: pixel(Seen(2.0, r / FX)),
                "triangulation, frontal wall",
            ),
            sweep(
                "bias",
                RADIUS,
                "distance to the image's middle [px]",
                lambda r: pixel(Seen(2.0, r / FX), FLIGHT),
                "time of flight, frontal wall",
            ),
        ),
        ("thickness",),
    ),
    "focal_length": Picture(
        (
            sweep(
                "bias",
                RADIUS,
                "distance to the image's middle [px]",
                lambda r: pixel(Seen(2.0, r / FX), FLIGHT),
                "time of flight, frontal wall at 2 m",
            ),
            sweep(
                "bias",
                np.arange(-320.0, 321, 8),
                "column from the middle [px]",
                lambda u: pixel(Seen(2.0 / (1 - u / FX * np.tan(np.pi / 6)), u / FX, 0, np.pi / 6)),
                "any sensor, a wall tilted by 30 deg",
            ),
        ),
        ("relative",),
    ),
    "principal_point": Picture(
        (
            sweep(
                "bias",
                np.linspace(-60, 60, 121),
                "tilt of the wall about the image's columns [deg]",
                lambda a: tilted(np.deg2rad(a)),
                "middle of the image, wall at 2 m",
            ),
        ),
        ("cx", "cy"),
    ),
    "lens_distortion": Picture(
        (image("bias", lambda: wall(tilt=np.deg2rad(30)), "a wall tilted by 30 deg, triangulation"),),
        ("k1", "k2", "k3", "p1", "p2"),
    ),
    "defocus": Picture((across_edge("bias", beside_edge, EDGE_NOTE),), ("width",)),
    "illumination_vignetting": Picture(
        (image("light", vignetted, "share of the light on the axis"),), ("exponent",), ("exponent",)
    ),
    "projector_shadow": Picture(
        (
            image(
                "dropout",
                lambda: card_before_wall(1.0, 2.0, Principle.STRUCTURED_LIGHT),
                "a card at 1 m before a wall at 2 m",
                window=AROUND_CARD,
                outline=CARD,
                steps=True,
            ),
        ),
        ("baseline",),
    ),
    "ambient_light": Picture(
        (
            sweep("noise", DEPTH, RANGE_LABEL, lambda z: lit(0.0, z), "time of flight, frontal wall"),
            sweep(
                "dropout",
                DEPTH,
                RANGE_LABEL,
                lambda z: lit(0.0, z),
                "time of flight in daylight",
                values={"ambient": 60_000.0},
            ),
        ),
        ("ambient",),
    ),
    "ambient_flicker": Picture(
        (
            sweep(
                "noise",
                np.linspace(0, 30, 241),
                "time [ms]",
                lambda t: at(2.0, FLIGHT, reflectance=one(0.8), moment=Moment(time=t / 1000, ambient=500.0)),
                "time of flight, wall at 2 m, lamps of 500 lux",
            ),
        ),
        ("amplitude",),
    ),
    "subsurface_scattering": Picture(
        (
            sweep(
                "bias",
                RADIUS,
                "distance to the image's middle [px]",
                lambda r: pixel(Seen(1.0, r / FX), FLIGHT),
                "time of flight",
            ),
            sweep(
                "bias",
                RADIUS,
                "distance to the image's middle [px]",
                lambda r: pixel(Seen(1.0, r / FX)),
                "triangulation",
            ),
        ),
        ("path",),
    ),
    "specular_reflection": Picture(
        (
            sweep(
                "light",
                np.linspace(0, 80, 161),
                "incidence [deg]",
                lambda a: tilted(np.deg2rad(a)),
                "amplitude over that of a dull surface",
            ),
            sweep(
                "dropout",
                np.linspace(0, 80, 161),
                "incidence [deg]",
                lambda a: tilted(np.deg2rad(a)),
                "share of pixels without a value",
            ),
        ),
        ("strength",),
    ),
    "multipath": Picture(
        (
            sweep(
                "bias",
                np.linspace(0, 1.87, 188),
                "how much longer the other way is [m]",
                lambda w: at(2.0, FLIGHT, indirect=Indirect(one(0.2), one(w))),
                "indirect light of a fifth of the direct one, at 80 MHz",
            ),
        ),
        ("strength",),
    ),
    "stray_light": Picture(
        (
            image(
                "bias",
                lambda: card_before_wall(1.5, 2.2, FLIGHT),
                "a bright card 0.7 m before a wall",
            ),
        ),
        ("fraction",),
    ),
}
