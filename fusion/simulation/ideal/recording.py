"""An ideal recording of any format as the recording that a sensor would have made."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np

from fusion import __version__
from fusion.errors import RecordingError
from fusion.progress import each
from fusion.recording.recording import Frame, Recording
from fusion.recording.writing.convert import copy_color_apart, copy_scene_mesh
from fusion.recording.writing.write import fill_recording
from fusion.sensor.correction.estimate import reflectance_of
from fusion.sensor.files.sensor_file import write_sensor
from fusion.sensor.moment import Moment
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.simulation.ideal.channels import Channel, between_in, looked_up, normals_in, segmentation_in, share_in
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.sense import sense_all, stated_by
from fusion.simulation.ideal.slopes import facing_of
from fusion.simulation.ideal.view import unknown_to
from fusion.simulation.rendering.light_level import with_light_level


@dataclass(frozen=True)
class Further:
    """What is given beside the depth; None where it is not."""

    # normals, segmentation: images
    normals: Channel | None = None
    segmentation: Channel | None = None
    reflectance: Channel | float | None = None  # images, or one for all
    # reflectance of each label of the segmentation; empty: not given
    table: dict[int, float] = field(default_factory=dict)
    # the recording's IR images tell the reflectance: they are those of a lamp at the camera, without noise and loss, of
    # 1000 counts for a white surface at 1 m, as `fusion simulate` without a sensor makes them
    from_ir: bool = False
    depth: Channel | None = None  # images of it, finer than the recording's counts
    # rows, columns, lit: images of depth between the pixels and of a shadow pass, as in `IdealFrame`
    rows: Channel | None = None
    columns: Channel | None = None
    lit: Channel | None = None

    @property
    def held(self) -> list[str]:
        """Names of the images."""
        return [one.name for entry in fields(self) if isinstance(one := getattr(self, entry.name), Channel)]

    def beside(self, found: "Further") -> "Further":
        """This, and what was found where nothing is given."""
        told = self.reflectance is not None or self.table or self.from_ir
        more = [name for name in found.held if getattr(self, name) is None and not (told and name == "reflectance")]
        return replace(self, **{name: getattr(found, name) for name in more})


def ideal_frames(recording: Recording, further: Further) -> Iterator[IdealFrame]:
    """The frames of a recording with what is given beside them. Raises RecordingError."""
    moments = _moments(recording)
    rounding = 0.0
    for index in range(len(recording)):
        if index == 0 and further.depth is None and recording.depth_counts(0) is not None:
            rounding = 1 / recording.camera.depth_scale
        frame, camera = recording[index], recording.camera
        if further.depth is not None:
            frame = replace(frame, depth=np.asarray(further.depth.image(index, camera.shape), np.float32))
        normals = labels = None
        if further.normals is not None:
            normals = normals_in(further.normals, index, camera, frame.depth)
        if further.segmentation is not None:
            labels = segmentation_in(further.segmentation, index, camera.shape)
        ideal = IdealFrame(frame.depth, normals, None, labels, moments[index], rounding)
        if further.rows is not None and further.columns is not None:
            rows, columns = (between_in(images, index, camera) for images in (further.rows, further.columns))
            ideal = replace(ideal, rows=rows, columns=columns)
        if further.lit is not None:
            ideal = replace(ideal, lit=share_in(further.lit, index, camera.shape))
        yield replace(ideal, reflectance=_reflectance(recording, frame, ideal, further))


def fill_sensed(
    folder: Path, recording: Recording, sensor: Sensor, seed: int = 0, further: Further | None = None
) -> list[str]:
    """Write what the sensor would have made of an ideal recording into a folder that is being made.

    `truth/` tells the sensor, the seed and what could not be known.

    Returns:
        What could not be known, one sentence each.

    Raises:
        RecordingError: a frame, or an image beside it, cannot be read.
        SensorError: a map of the sensor does not fit the images.
    """
    further, sensor = further or Further(), with_light_level(sensor)
    first = next(ideal_frames(recording, further), None)
    if first is None:
        raise RecordingError("the recording is empty", recording.path, "no frame", "one or more")
    scene = copy_scene_mesh(recording, folder)
    frames = sense_all(ideal_frames(recording, further), recording.camera, sensor, seed)
    sensed = _colored(recording, each(frames, "sensing", len(recording)))
    camera = stated_by(recording.camera, sensor)
    fill_recording(folder, camera, sensed, recording.poses, recording.telemetry, scene)
    copy_color_apart(recording, folder)
    unknown = unknown_to(sensor, first)
    if missed := sensor.works.told(np.asarray(first.depth), sensor.name):
        unknown.insert(0, missed)
    _write_truth(folder / "truth", recording, sensor, seed, unknown)
    return unknown


def _colored(recording: Recording, frames: Iterator[Frame]) -> Iterator[Frame]:
    """The frames at the recording's time, with its colours."""
    has = recording.has_color
    for frame in frames:
        colored = has is not None and has[frame.index] and not recording.color_is_apart
        color = recording[frame.index].color if colored else None
        yield replace(frame, timestamp=float(recording.timestamps[frame.index]), color=color)


def _moments(recording: Recording) -> list[Moment]:
    """Time stamps count from switch-on; temperature, light and table angle are those of the telemetry."""
    columns = {name: recording.telemetry_at_frames(name) for name in ("temperature_c", "ambient_lux", "turntable_deg")}

    def at(name: str, index: int, usual: float) -> float:
        column = columns[name]
        return usual if column is None else float(column[index])

    lux = float(recording.scene.get("ambient_lux") or 0.0)
    return [
        Moment(
            time=float(stamp),
            temperature=at("temperature_c", index, float("nan")),
            ambient=at("ambient_lux", index, lux),
            table_angle=float(np.deg2rad(at("turntable_deg", index, 0.0))),
        )
        for index, stamp in enumerate(recording.timestamps)
    ]


def _reflectance(recording: Recording, frame: Frame, ideal: IdealFrame, further: Further) -> np.ndarray | float | None:
    if isinstance(further.reflectance, Channel):
        return share_in(further.reflectance, frame.index, recording.camera.shape)
    if further.table and ideal.segmentation is not None:
        return looked_up(further.table, ideal.segmentation.astype(np.int64))
    if not further.from_ir:
        return further.reflectance
    if frame.ir is None:
        raise RecordingError("there is no IR image to tell the reflectance", recording.path, f"frame {frame.index}")
    incidence = facing_of(frame.depth, recording.camera, ideal.rounding, normals=False).incidence
    with np.errstate(all="ignore"):
        seen = reflectance_of(View(recording.camera, frame.depth, incidence, ir=frame.ir))
    return np.clip(seen, 0, 1).astype(np.float32)


def _write_truth(folder: Path, recording: Recording, sensor: Sensor, seed: int, unknown: list[str]) -> None:
    folder.mkdir()
    write_sensor(folder / "sensor.json", sensor)
    content = {"ideal": Path(recording.path).name, "sensor": sensor.name, "seed": seed, "fusion": __version__}
    text = json.dumps({**content, "not_known": unknown}, indent=1)
    (folder / "truth.json").write_text(text + "\n", encoding="utf-8")
