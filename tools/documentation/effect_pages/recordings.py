"""What to record so that `fusion explain` can name an effect: sets of recordings, and which of them tell of which.

From what separates an effect from those that look alike: distances for laws of depth, tilts for those of the lens,
brightness for those of light, edges for those of neighbours, time for those of warmth, motion for those of clocks. The
planner (`fusion/discrepancy/planning/menu.py`) has larger ones for what it has already seen.
"""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Take:
    """One recording, as `fusion simulate SCENE --set NAME=VALUE ...` makes its like."""

    scene: str
    settings: Mapping[str, str]


@dataclass(frozen=True)
class Series:
    """Recordings that belong together."""

    text: str  # what to do, as a part of a sentence
    takes: tuple[Take, ...]
    counts: float = 1000.0  # per metre, of the files


def _take(scene: str, **settings: object) -> Take:
    return Take(scene, {name: str(value) for name, value in settings.items()})


WALLS = (
    *(_take("wall", distance_m=d, frames=6) for d in (0.6, 0.9, 1.3, 1.8, 2.5, 3.5)),
    *(_take("wall", distance_m=d, tilt_deg=t, frames=6) for d in (1.0, 1.8) for t in (-35, 35)),
)
FLAT = (
    "a flat wall from six distances between 0.6 and 3.5 m, frontally, and from 1 and 1.8 m at 35 degrees to both "
    "sides, set up anew each time"
)
SERIES = {
    "walls": Series(FLAT, WALLS),
    "fine walls": Series(f"{FLAT}, in files that count in tenths of a millimetre", WALLS, counts=10_000.0),
    "papers": Series(
        "a wall with squares of black, grey and white paper, from 0.8 to 2.5 m, twice at 25 degrees",
        tuple(
            _take("patches", distance_m=d, tilt_deg=t, frames=6) for d, t in ((0.8, 0), (1.2, 25), (1.8, 0), (2.5, -25))
        ),
    ),
    "steps": Series(
        "a board 30 cm before a wall, its edge across the picture, from 0.7 to 2.2 m",
        tuple(_take("step", distance_m=d, frames=6) for d in (0.7, 1.0, 1.5, 2.2)),
    ),
    "contrast": Series(
        "a black board 30 cm before a white wall and a white one before a black wall, its edge across the picture, "
        "from 0.7 and 1.5 m",
        tuple(
            _take("step", distance_m=d, near_reflectance=near, far_reflectance=far, frames=6)
            for d in (0.7, 1.5)
            for near, far in ((0.05, 0.8), (0.8, 0.05))
        ),
    ),
    "strip": Series(
        "a board 30 cm wide and as far before a wall, both its upright edges in the picture, from 0.7 to 2.2 m",
        tuple(_take("step", distance_m=d, width_m=0.3, frames=6) for d in (0.7, 1.0, 1.5, 2.2)),
    ),
    "corners": Series(
        "two walls that meet, from 1.2 and 1.8 m, once with the second one bare and once covered with black cloth",
        tuple(_take("corner", distance_m=d, black=b, frames=6) for d in (1.2, 1.8) for b in ("no", "yes")),
    ),
    "slab": Series(
        "a slab of soap, wax or marble against a wall of paper, bare and with a sheet of paper over it, from 0.6, 0.9 "
        "and 1.3 m, and from 1 and 2 m at 45 degrees to both sides",
        (
            *(_take("slab", distance_m=d, covered=c, frames=6) for d in (0.6, 0.9, 1.3) for c in ("no", "yes")),
            *(_take("slab", distance_m=d, tilt_deg=t, frames=6) for d in (1.0, 2.0) for t in (-45, 45)),
        ),
    ),
    "near card": Series(
        "a wall from 1.5 and 2.2 m, each with and without a white card close to the camera",
        tuple(_take("near-card", distance_m=d, card=c, frames=6) for d in (1.5, 2.2) for c in ("no", "yes")),
    ),
    "warm-up": Series(
        "a board before a wall from 0.8, 1.2 and 2 m, each over 50 minutes from a minute after switching on, with the "
        "temperature",
        tuple(_take("warm-up", distance_m=d, frames=12) for d in (0.8, 1.2, 2.0)),
    ),
    "far papers": Series(
        "large sheets of black, grey and white paper from 2.5, 3.2 and 4 m",
        tuple(
            _take("patches", distance_m=d, reflectance="0.02,0.05,0.1,0.3,0.8", patch_m=0.5, frames=6)
            for d in (2.5, 3.2, 4.0)
        ),
    ),
    "slant": Series(
        "a wall at 60 degrees, so that near and far are in one picture, from 1.2, 1.6 and 2 m",
        tuple(_take("wall", distance_m=d, tilt_deg=60, frames=6) for d in (1.2, 1.6, 2.0)),
    ),
    "minute": Series(
        "a board before a wall from 1 and 1.6 m, for a minute each, warm and nothing moved",
        tuple(_take("warm-up", distance_m=d, frames=100, minutes=1, start_s=6000) for d in (1.0, 1.6)),
    ),
    "daylight": Series(
        "the wall from 0.8, 1.5 and 2.5 m in a dark room and in daylight of 5000 lux",
        tuple(_take("wall", distance_m=d, ambient_lux=lux, frames=12) for d in (0.8, 1.5, 2.5) for lux in (0, 5000)),
    ),
    "table": Series(
        "an object of known shape, 30 cm or larger, that fills the picture on the turntable, from 15 and from 35 "
        "degrees above, with the angles that the table states",
        tuple(_take("turntable", frames=36, turns=1, elevation_deg=e, scale=3, distance_m=0.8) for e in (15, 35)),
    ),
    "approach": Series(
        "a flat wall that the camera rolls towards on a rail at 0.6 m/s, from 2.4 to 0.6 m, at 30 frames a second",
        tuple(_take("approach", near_m=d, far_m=d + 0.6) for d in (0.6, 1.2, 1.8)),
    ),
    "walk": Series(
        "a room of known shape that the camera sweeps through at 30 frames a second, three times",
        tuple(_take("room", frames=30, sweep_deg=s) for s in (30, 40, 50)),
    ),
}
ADVICE = {
    "turntable_encoder_error": ("table",),
    "turntable_eccentricity": ("table",),
    "turntable_wobble": ("table",),
    "pose_jitter": ("walls",),
    "timestamp_offset": ("walk",),
    "rolling_shutter": ("walk",),
    "motion_blur": ("walk",),
    "refraction": ("walls",),
    "focal_length": ("walls", "steps"),
    "principal_point": ("walls",),
    "lens_distortion": ("walls",),
    "defocus": ("steps", "contrast"),
    "illumination_vignetting": ("walls", "papers"),
    "projector_shadow": ("steps",),
    "ambient_light": ("daylight",),
    "ambient_flicker": ("daylight",),
    "subsurface_scattering": ("slab",),
    "specular_reflection": ("walls",),
    "multipath": ("corners",),
    "stray_light": ("near card", "papers"),
    "edge_fattening": ("strip",),
    "projector_thermal_drift": ("warm-up",),
    "disparity_offset": ("walls", "warm-up"),
    "disparity_distortion": ("walls",),
    "speckle_noise": ("walls",),
    "pixel_locking": ("walls",),
    "vertical_banding": ("walls",),
    "emitter_parallax": ("walls",),
    "mixed_pixels": ("steps", "contrast"),
    "pixel_crosstalk": ("papers", "strip"),
    "sensor_interference": ("minute",),
    "motion_artifact": ("approach",),
    "cyclic_error": ("walls",),
    "amplitude_error": ("papers", "walls"),
    "column_delay": ("walls",),
    "phase_wrapping": ("slant",),
    "lateral_noise": ("steps", "walls"),
    "fixed_pattern": ("walls",),
    "temperature_drift": ("warm-up",),
    "depth_scale": ("walls",),
    "depth_offset": ("slab", "warm-up"),
    "tabulated": ("walls",),
    "saturation": ("papers", "walls"),
    "amplitude_dropout": ("far papers", "papers"),
    "axial_noise": ("walls",),
    "temporal_filtering": ("walls",),
    "depth_quantization": ("fine walls",),
}


def advice(name: str) -> str:
    """What to record for an effect, as one sentence."""
    said = "; ".join(SERIES[series].text for series in ADVICE[name])
    return said[0].upper() + said[1:] + "."
