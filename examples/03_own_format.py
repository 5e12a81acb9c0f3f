"""
A recording format of your own
==============================

Your rig writes one ``.npz`` a frame, with millimetres and a time in it. A recording is a camera, time stamps and a
function that loads one frame; so a format is one function that opens the folder and one that reads a frame.
"""

import tempfile
from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fusion

CAMERA = fusion.Camera(320, 240, fx=287.9, fy=287.9, cx=159.5, cy=119.5, principle="structured_light")


def open_rig(folder: Path) -> fusion.Recording:
    """The recording in a folder of `.npz` files, in the order of their names."""
    files = sorted(folder.glob("*.npz"))
    if not files:
        raise fusion.FusionError("no recording of the rig", folder, "no .npz file", "one for each frame")
    stamps = np.array([float(np.load(file)["time_s"]) for file in files])
    return fusion.Recording(folder, "rig", CAMERA, stamps, partial(load, files, stamps))


def load(files: list[Path], stamps: np.ndarray, index: int) -> fusion.Frame:
    """One frame: planar depth in metres, NaN where there is none."""
    counts = np.load(files[index])["depth_mm"]
    depth = np.where(counts > 0, counts / 1000, np.nan).astype(np.float32)
    return fusion.Frame(index, stamps[index], depth)


# %%
# A folder as the rig would write it: a tilted wall at some 1.2 m, seen eight times.

place = Path(tempfile.mkdtemp())
wall = np.linspace(1.1, 1.3, CAMERA.width, dtype=np.float32) * np.ones(CAMERA.shape, np.float32)
for i, frame in enumerate(fusion.sense_all([wall] * 8, CAMERA, fusion.read_sensor("kinect-v1"), seed=1)):
    counts = np.nan_to_num(1000 * frame.depth).astype(np.uint16)
    np.savez(place / f"{i:04d}.npz", depth_mm=counts, time_s=i / 30)

recording = open_rig(place)
plt.imshow(recording[0].depth, cmap="magma_r")
plt.colorbar(label="depth [m], white: none")
recording

# %%
# It is a recording like any other: the doctor looks at it ...

for finding in fusion.inspect(recording).findings:
    print(f"{finding.severity:>7}  {finding.check}: {finding.seen}")

# %%
# ... and once it is written as a native folder every command takes it (``fusion turntable as_native``).

fusion.convert_recording(recording, place / "as_native")
fusion.open_recording(place / "as_native")
