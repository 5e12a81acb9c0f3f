"""How small or large an object may be: one simulated scan with all lengths multiplied, noise of the sensor as well.

A scan that measured everything in voxels, noise and the object's size would give the same figures at every size.

python -m tools.reproduce.scaled_object [0.1 0.25 0.5 1 2 4]
"""

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fusion.errors import FusionError
from fusion.geometry.camera import Principle
from fusion.mesh.comparison.distances import signed_distances
from fusion.mesh.mesh import Mesh
from fusion.recording.open import open_recording
from fusion.recording.writing.write import write_recording
from fusion.scan.pipeline import scan_turntable
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor
from fusion.simulation.demo.demo import demo_truth
from tools.reproduce.followed import CAMERA, SETTINGS, small_recording

NOISE = 0.002  # [m] that the sensor's model states, of the object as it is
TALL = float(np.ptp(demo_truth().vertices[:, 2]))


def scanned(folder: Path, scale: float) -> str:
    """What comes of the object this many times as large, as a row of a table."""
    frames = (replace(frame, depth=frame.depth * np.float32(scale)) for frame in open_recording(folder / "as_it_is"))
    write_recording(folder / f"{scale:g}", replace(CAMERA, depth_scale=CAMERA.depth_scale / scale), frames)
    sensor = Sensor("scaled", Principle.TIME_OF_FLIGHT, (AxialNoise(c0=NOISE * scale),))
    assert SETTINGS.voxel is not None and SETTINGS.truncation is not None
    voxel, truncation = SETTINGS.voxel * scale, SETTINGS.truncation * scale
    settings = replace(SETTINGS, sensor=sensor, force=True, voxel=voxel, truncation=truncation)
    try:
        scan = scan_turntable(open_recording(folder / f"{scale:g}"), settings)
    except FusionError as error:
        return f"| {100 * TALL * scale:.0f} cm | {error.what} | | | |"
    truth = demo_truth()
    off = signed_distances(scan.mesh.vertices, Mesh(truth.vertices * scale, truth.faces))
    rms = float(np.sqrt(np.mean(off**2))) / voxel
    placed, turned = int(scan.trajectory.valid.sum()), np.rad2deg(abs(scan.steps.mean))
    size, verdict = f"{100 * TALL * scale:.0f} cm", scan.judgement.worth.word
    return f"| {size} | {rms:.2f} | {placed} of {len(scan.trajectory)} | {turned:.2f} deg | {verdict} |"


def main() -> int:
    print("| height | rms [pixels] | placed | step (15 deg) | verdict |\n|---|---|---|---|---|")
    with TemporaryDirectory() as folder:
        small_recording(Path(folder) / "as_it_is")
        for scale in map(float, sys.argv[1:] or ("0.1", "0.25", "0.5", "1", "2", "4")):
            print(scanned(Path(folder), scale), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
