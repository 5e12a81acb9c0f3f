"""Noise of a camera from a target at many poses: measure, fit the laws, and put them into the sensor model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fusion.calibration.depth.known import start
from fusion.calibration.noise.laws.axial import AxialLaw, axial_law
from fusion.calibration.noise.laws.dropout import DropoutLaw, dropout_law
from fusion.calibration.noise.laws.lateral import LateralLaw, lateral_law
from fusion.calibration.noise.poses import Pose, read_poses
from fusion.errors import FusionError
from fusion.geometry.camera import Camera
from fusion.progress import stage
from fusion.recording.checks.depth_values import implausible
from fusion.recording.looking.copies import refuse_repeated
from fusion.recording.recording import Recording
from fusion.sensor.effect import Effect
from fusion.sensor.sensor import Sensor

FEW_FRAMES = 30  # a spread is then known to a tenth or worse
FEW_POSES = 12


@dataclass(frozen=True)
class NoiseSettings:
    """What a noise calibration may be told.

    Attributes:
        camera: calibrated camera; None takes that of the recordings.
        sensor: what is already known of the sensor; its noise laws are fitted anew, all else stays.
        force: take recordings or models of another camera.
    """

    camera: Camera | None = None
    sensor: Sensor | None = None
    force: bool = False


@dataclass(frozen=True)
class NoiseCalibration:
    """Noise laws with their evidence."""

    sensor: Sensor  # the model with the laws' effects
    camera: Camera  # that it belongs to
    poses: list[Pose]  # of the target, as they were measured
    # axial, lateral, dropout: the laws; None where the data show none
    axial: AxialLaw
    lateral: LateralLaw | None
    dropout: DropoutLaw | None
    notes: tuple[tuple[str, str], ...]  # ("ok", "warning" or "bad", sentence)

    def __repr__(self) -> str:
        return f"<NoiseCalibration by {len(self.poses)} poses: {self.sensor!r}>"


def calibrate_noise(recordings: Sequence[Recording], settings: NoiseSettings | None = None) -> NoiseCalibration:
    """Find the noise of a camera from recordings of a flat target (or a wall) at several distances and tilts.

    Args:
        recordings: one pose each, or several poses one after the other.
        settings: camera, known sensor and so on.
    Raises:
        FusionError: no recording, one given twice, recordings of different cameras, no target in view, no noise.

    >>> found = fusion.calibrate_noise([fusion.open_recording(f"wall_{i}") for i in range(5)])
    >>> [effect.name for effect in found.sensor.effects]
    ['axial_noise']
    """
    settings = settings or NoiseSettings()
    if not recordings:
        raise FusionError("no recording of a target", found=0, expected="a flat target at several distances and tilts")
    refuse_repeated(recordings)
    begin = start(recordings, settings.camera, settings.sensor, settings.force)
    model = settings.sensor or begin.known
    model = replace(model, principle=begin.known.principle, sensor=begin.sensor, serial=begin.serial, left_out=())
    poses, lost = read_poses(recordings, begin.camera, begin.known)
    notes = [note for note in begin.notes if note[0] == "warning"]  # the others speak of a depth law
    with stage("fitting"):
        return calibrate_poses(poses, begin.camera, model, (*notes, *(("warning", text) for text in lost)))


def calibrate_poses(
    poses: list[Pose], camera: Camera, model: Sensor, notes: tuple[tuple[str, str], ...] = ()
) -> NoiseCalibration:
    """The same from poses that are already measured; `model`: what the laws are put into."""
    principle = model.principle.or_else(camera.principle)
    axial = axial_law(poses, principle, model, camera.fx * abs(model.baseline))
    lateral, dropout = lateral_law(poses, camera.fx), dropout_law(poses)
    laws: list[tuple[Effect, dict[str, float], str]] = [(axial.effect, axial.std, _axial_source(axial))]
    # what these poses cannot show keeps the deviation that it had
    laws[0][1].update({n: s for n in axial.kept if isinstance(s := model.std.get(("axial_noise", n)), float)})
    if lateral is not None:
        laws.append((lateral.effect, lateral.std, _lateral_source(lateral)))
    if dropout is not None:
        deviations = dict(zip(("ir_threshold", "width"), dropout.std, strict=True))
        said = f"fusion calibrate noise: missing values over amplitude at {len(dropout.ir)} poses"
        laws.append((dropout.effect, deviations, said))
    sensor = model
    for effect, std, source in laws:
        sensor = _with(sensor, effect, std, source)
    return NoiseCalibration(
        sensor, camera, poses, axial, lateral, dropout, (*notes, *_notes(poses, axial, lateral, dropout))
    )


def _with(sensor: Sensor, effect: Effect, std: dict[str, float], source: str) -> Sensor:
    """The sensor with an effect in place of its own of that name."""
    deviations = {key: value for key, value in sensor.std.items() if key[0] != effect.name}
    deviations |= {(effect.name, name): value for name, value in std.items()}
    return replace(sensor.having(effect), std=deviations, sources=sensor.sources | {effect.name: source})


def _axial_source(axial: AxialLaw) -> str:
    z, tilt = axial.places.depth, np.rad2deg(axial.places.tilt)
    return (
        f"fusion calibrate noise: {len(z)} poses, {np.min(z):.2f} to {np.max(z):.2f} m, {np.min(tilt):.0f} to "
        f"{np.max(tilt):.0f} deg; {axial.form.title}; {axial.best.rms * 1e3:.3f} mm rms left over"
    )


def _lateral_source(lateral: LateralLaw) -> str:
    where = "" if lateral.edges.shadowed.all() or not lateral.edges.shadowed.any() else " not beside a shadow"
    return f"fusion calibrate noise: {len(lateral.held.heldout)} edges{where}, {lateral.held.form.title}"


def _notes(
    poses: list[Pose], axial: AxialLaw, lateral: LateralLaw | None, dropout: DropoutLaw | None
) -> list[tuple[str, str]]:
    notes = []
    for name, record in axial.visible.hidden.items():
        text = f"axial_noise.{name} cannot be seen in these recordings"
        text += f" and stays {axial.kept[name]:.3g}, as --sensor has it" if name in axial.kept else ""
        notes.append(("warning", f"{text}; to see it, record {record}"))
    for name, value, std in zip(axial.form.names, axial.best.numbers, axial.best.std, strict=True):
        if name in ("angle", "sunlight") and abs(value) < 2 * std:
            notes.append(
                ("warning", f"axial_noise.{name} is not established: {value:.2g} with a deviation of {std:.2g}")
            )
    if text := implausible(float(np.median([pose.seen.depth for pose in poses]))):
        notes.append(("bad", text))
    if len(poses) < FEW_POSES:
        count = "one pose" if len(poses) == 1 else f"{len(poses)} poses"
        notes.append(("warning", f"{count}: intervals are wide; 9 distances at 6 angles each are usual"))
    fewest = min(pose.seen.frames for pose in poses)
    if fewest < FEW_FRAMES:
        notes.append(("warning", f"a pose has {fewest} frames: 100 are usual"))
    used = {pose.name for pose in axial.poses}
    if quiet := [pose for pose in poses if pose.name not in used]:
        step = max(pose.step for pose in quiet)
        beside = f" beside steps of {step * 1e3:.2g} mm, to which depth is rounded" if step > 0 else ""
        notes.append(("warning", f"{len(quiet)} poses show no noise{beside}: left out of the axial law"))
    if lateral is None:
        notes.append(("warning", "no lateral noise: no target that stands free with its left and right edge in view"))
    elif len(lateral.best.numbers) > 1:
        grows = float(lateral.best.numbers[1])
        notes.append(("ok", f"lateral noise grows with the tilt, {grows:.3f} px theta / (pi/2 - theta), which "
                            "lateral_noise cannot hold: a constant is written"))  # fmt: skip
    worst = max(poses, key=lambda pose: pose.seen.no_data)
    if dropout is None and worst.seen.no_data > 0.02:
        text = (
            f"up to {100 * worst.seen.no_data:.0f} % of the values are missing ({worst.name}), which does not follow "
        )
        notes.append(("warning", text + "the infrared brightness: no dropout law is written"))
    return notes
