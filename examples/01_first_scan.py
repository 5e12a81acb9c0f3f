"""
A first scan
============

An owl on a turntable before a Kinect v1, from the recording to the distance between the scan and the truth.

The recording is simulated, so that the truth is known and everybody sees the same: half of the Kinect's pixels, 32
images over one turn and a tenth, a table that turns unevenly.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt

import fusion

folder = Path(tempfile.mkdtemp())
camera = replace(fusion.find_camera("kinect-v1"), width=320, height=240, fx=287.9, fy=287.9, cx=159.5, cy=119.5)
turning = fusion.built_in("turntable", {"frames": 32, "turns": 1.1, "uneven_sd_deg": 0.5, "distance_m": 0.7})
simulation = fusion.simulate(replace(turning, camera=camera), fusion.read_sensor("kinect-v1"), seed=1)
fusion.write_simulation(folder / "my_scan", simulation)

# %%
# What is in it
# -------------
# A recording is opened whatever its format is, and its images are read when they are asked for. White is what has no
# depth: the projector's shadow, and edges.

recording = fusion.open_recording(folder / "my_scan")
plt.imshow(recording[0].depth, cmap="magma_r", vmin=0.5, vmax=1.2)
plt.colorbar(label="depth [m]")
recording

# %%
# ``inspect`` looks for what would spoil a scan: a wrong unit, wrong time stamps, a camera that does not fit.

for finding in fusion.inspect(recording).findings:
    print(f"{finding.severity:>7}  {finding.check}: {finding.seen}")

# %%
# The scan
# --------
# The table's axis and the angle of each image are found from the images; no mask and no marker is needed.

scan = fusion.scan_turntable(recording, fusion.ScanSettings(sensor=fusion.read_sensor("kinect-v1")))
print("\n".join(scan.judgement.lines()))
scan

# %%
# How right it is
# ---------------
# The truth lies beside a simulated recording. Red stands too far out, blue too far in, by a millimetre and more.

truth = fusion.read_mesh(folder / "my_scan" / "truth" / "mesh.ply")
found = fusion.compare(scan.mesh, truth, fusion.CompareSettings(align=False))
print(found)
found.mesh

# %%
# The mesh goes on to other programs: in metres, z up, the plate at z = 0.

fusion.write_mesh(folder / "owl.ply", scan.mesh)
