"""What stood before the sensor of a simulation, as a renderer's passes beside its recording: `truth/passes/`."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from fusion.files.output.publish import atomic_file
from fusion.progress import each
from fusion.recording.recording import Recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image
from fusion.simulation.ideal.channels import channel
from fusion.simulation.ideal.frame import IdealFrame
from fusion.simulation.ideal.recording import Further
from fusion.simulation.rendering.exposure import Exposures
from fusion.simulation.simulate import Simulation

PASSES = Path("truth") / "passes"
NAMES = ("depth", "normals", "reflectance", "rows", "columns", "lit")
FINER = 64  # values a pixel: `simulate` halves the way between two pixels six times


def write_passes(recording: Path, simulation: Simulation, finer: int = 1) -> None:
    """Perfect depth, normals, reflectance and what a projector reaches, `.npy` files of each frame in a folder of each.

    Args:
        recording: folder of the simulation.
        finer: depth so many times as fine along rows and columns too; 1: not.
    """
    frames = each(ideal_of(simulation, finer), "rendering passes", len(simulation))
    for index, frame in enumerate(frames):
        for name in NAMES:
            value = getattr(frame, name)
            if value is not None:
                _write(recording / PASSES / name / f"{index:06d}.npy", np.asarray(value, np.float32))


def passes_of(recording: Recording, sensor: Sensor) -> Further | None:
    """Those beside a recording, as far as they hold for a sensor; None where there are none. Raises RecordingError."""
    home = Path(recording.path) / PASSES
    if not home.is_dir():
        return None
    found = {name: channel(home / name, name, len(recording)) for name in NAMES if (home / name).is_dir()}
    own = read_sensor(home.parent / "sensor.json")
    if own.effect("projector_shadow") != sensor.effect("projector_shadow"):
        found.pop("lit", None)  # it was another projector's
    get = found.get
    return Further(
        depth=get("depth"), normals=get("normals"), reflectance=get("reflectance"),
        rows=get("rows"), columns=get("columns"), lit=get("lit"),
    )  # fmt: skip


def _write(path: Path, values: Image) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_file(path) as partial, partial.open("wb") as file:
        np.save(file, values)


def ideal_of(simulation: Simulation, finer: int = FINER) -> Iterator[IdealFrame]:
    """What stood before the sensor of a simulation: perfect depth, normals, reflectance, the light of its projector.

    Args:
        simulation: its sensor says where a projector stands, and nothing else of it counts.
        finer: values a pixel along rows and columns; 1: only the pixels themselves.

    >>> wall = fusion.simulate(fusion.built_in("wall", {"distance_m": 1.2}), fusion.read_sensor("kinect-v1"))
    >>> from fusion.simulation.ideal.passes import ideal_of
    >>> next(ideal_of(wall, finer=3))
    <IdealFrame: 640 x 480; depth, normals, reflectance, rows, columns, lit>
    """
    projector = tuple(effect for effect in simulation.sensor.effects if effect.name == "projector_shadow")
    perfect = replace(simulation.sensor, effects=projector)
    exposures = Exposures(simulation.scene, perfect, simulation.camera, simulation.turned_deg)
    for index in range(len(simulation)):
        moment = simulation.moment(index)
        view = exposures.view(index, moment, np.random.default_rng(0))
        assert view.depth is not None
        frame = IdealFrame(view.depth, view.normals, view.reflectance, lit=view.lit, moment=moment)
        if finer > 1:
            rows, columns = _finer(exposures, simulation, index, finer)
            frame = replace(frame, rows=rows, columns=columns)
        yield frame


def _finer(exposures: Exposures, simulation: Simulation, index: int, finer: int) -> tuple[Image, Image]:
    """Depth (h, finer w) and (finer h, w) [m]: every image of the camera, moved by parts of a pixel."""
    camera, moment = simulation.camera, simulation.moment(index)
    height, width = camera.shape
    rows, columns = np.empty((height, finer * width), np.float32), np.empty((finer * height, width), np.float32)
    for place in range(finer):
        off = (place - finer // 2) / finer
        rows[:, place::finer] = exposures.depth(index, moment, replace(camera, cx=camera.cx - off))
        columns[place::finer] = exposures.depth(index, moment, replace(camera, cy=camera.cy - off))
    return rows, columns
