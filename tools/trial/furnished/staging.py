"""What is drawn before a camera moves: the sensor, the scene and the kind of motion, as suits what is concealed."""

from dataclasses import dataclass

import numpy as np

from tools.trial.furnished.cameras import drawn
from tools.trial.furnished.physics.lens import StatedCamera
from tools.trial.furnished.physics.sensor import C, SensorNumbers
from tools.trial.furnished.placing import PlacedScene, bowed_board, moved_thing
from tools.trial.furnished.plan import Spec
from tools.trial.furnished.rooms.parts import Furnished
from tools.trial.furnished.rooms.things import ROOMS

Rng = np.random.Generator
MOVING = {"motion_artifact", "rolling_shutter", "timestamp_offset", "tracking_drift", "temporal_filtering"}
SHARP = {"multipath", "mixed_pixels", "motion_artifact", "stray_light", "defocus", "pixel_crosstalk"}  # slow to make
NO_ZONES = {
    "pixel_crosstalk", "defocus", "stray_light", "mixed_pixels", "multipath", "unknown:ghost", "fixed_pattern",
    "rolling_shutter", "motion_artifact", "lens_distortion", "phase_wrapping", "subsurface_scattering", "refraction",
}  # fmt: skip
STANDING = {
    "temperature_drift", "projector_thermal_drift", "speckle_noise", "unknown:step", "lateral_noise", "axial_noise",
    "ambient_light",
}  # fmt: skip


@dataclass(frozen=True)
class DrawnStage:
    """Attributes:
    kind: of the sensor.
    motion: its kind.
    pose_factor: how much worse than stated the poses are.
    """

    kind: str
    motion: str
    sensor: SensorNumbers
    camera: StatedCamera
    scene: Furnished
    placed: PlacedScene
    pose_factor: float

    @property
    def name(self) -> str:
        return f"{self.kind}-{self.camera.width}x{self.camera.height}"


def staged(rng: Rng, spec: Spec) -> DrawnStage:
    names = set(spec.effects)
    principle = spec.principle or rng.choice(["itof", "itof", "tri"])
    if spec.null == "stated fattening":
        principle = "tri"
    if principle == "itof":
        zone = spec.null == "zone" or (rng.random() < 0.2 and not names & NO_ZONES)
        kind = "zone" if zone else "itof"
    else:
        kind = str(rng.choice(["sl", "stereo"]))
    sensor, camera = drawn(rng, kind, (160, 120) if names & SHARP else None)
    if names & {"mixed_pixels", "pixel_crosstalk", "defocus"}:
        sensor.fill = 0.0
    if "phase_wrapping" in names:
        _fold(rng, sensor)
    if "cyclic_error" in names and len(sensor.frequencies) > 1:
        rng.random()  # decides nothing any more, and keeps the numbers of all that is drawn after it
    room = str(rng.choice(list(ROOMS)))
    scene = ROOMS[room](rng)
    if "multipath" in names:
        room = str(rng.choice(["living", "corridor", "stairs"]))
        scene = ROOMS[room](rng)
    motion = _motion(rng, names)
    if sensor.fill and motion in ("sweep", "rail") and kind == "itof":
        sensor.fill = 0.0
    placed, factor = _placed(rng, spec, scene, room)
    if spec.null == "stated fattening":
        sensor.window = 5
    return DrawnStage(kind, motion, sensor, camera, scene, placed, factor)


def _fold(rng: Rng, sensor: SensorNumbers) -> None:
    """One frequency, whose period ends within the room."""
    f = float(rng.choice([45e6, 50e6, 60e6]))
    seen = sensor.counts * 0.6 / 4
    sensor.frequencies = [f]
    sensor.electrons = (C / 4 / np.pi / f) ** 2 * 2 / sensor.taps * sensor.shot / (0.003**2 * seen) * 1.25
    sensor.ambient = 0.2 * sensor.shot * sensor.electrons * seen


def _motion(rng: Rng, names: set[str]) -> str:
    if names & MOVING:
        motion = str(rng.choice(["sweep", "rail", "sweep"]))
    else:
        motion = str(rng.choice(["tripod", "tripod", "arm", "rail_stops", "sweep", "rail"]))
    slow = names & SHARP and not names & MOVING
    if slow or (names & STANDING and motion in ("sweep", "rail")):
        motion = "tripod"
    return "sweep" if "unknown:ripple" in names else motion


def _placed(rng: Rng, spec: Spec, scene: Furnished, room: str) -> tuple[PlacedScene, float]:
    """What stands there, and how much worse than stated the poses are."""
    if spec.null == "moved thing":
        return moved_thing(rng, scene.parts), 1.0
    if spec.null == "bowed board":
        return bowed_board(rng, scene.parts, room == "living"), 1.0
    if spec.null == "poses noisier":
        notes = ["poses three times worse than stated"]
        return PlacedScene(scene.parts, scene.parts, also=["pose_jitter"], notes=notes), 3.0
    notes = ["edges widened as stated, by a law of my own"] if spec.null == "stated fattening" else []
    return PlacedScene(scene.parts, scene.parts, notes=notes), 1.0


def weakest_of(sensor: SensorNumbers) -> tuple[float, float]:
    """[counts] threshold and width: where noise would reach 3 cm, or fold."""
    counts = np.logspace(0, 4, 400)
    limit = 0.03
    if len(sensor.frequencies) > 1:
        limit = min(0.03, 0.05 * C / 2 / max(sensor.frequencies) / np.pi * 1.0)
    weakest = float(counts[np.argmax(sensor.range_sigma(counts) < limit)])
    return round(weakest, 1), round(max(1.0, 0.1 * weakest), 2)
