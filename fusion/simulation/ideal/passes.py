"""What stood before the sensor of a simulation, as a renderer's passes beside its recording: `truth/passes/`."""

from pathlib import Path

import numpy as np

from fusion.files.output.publish import atomic_file
from fusion.progress import each
from fusion.recording.recording import Recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import Image
from fusion.simulation.ideal.channels import channel
from fusion.simulation.ideal.recording import Further
from fusion.simulation.ideal.rendered import ideal_of
from fusion.simulation.simulate import Simulation

PASSES = Path("truth") / "passes"
NAMES = ("depth", "normals", "reflectance", "rows", "columns", "lit")


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
