"""
A camera in the hand
====================

A camera that moves through a still room: every image says how well it was placed, and what nothing in view held fast.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import fusion

camera = fusion.Camera(320, 240, fx=287.9, fy=287.9, cx=159.5, cy=119.5)
sensor = fusion.read_sensor("kinect-v1")
place = Path(tempfile.mkdtemp()) / "my_room"
room = replace(fusion.built_in("room", {"frames": 12, "sweep_deg": 20}), camera=camera)
fusion.write_simulation(place, fusion.simulate(room, sensor, seed=1))

# %%
# Each line is one image: how far the points lie from the model in the mean, and how many found their place in it.

result = fusion.reconstruct(fusion.open_recording(place), fusion.ReconstructSettings(sensor=sensor))
for index, (residual, share) in enumerate(zip(result.residual, result.inlier_share, strict=True)):
    status = result.rejected.get(index, "ok")
    free = ", ".join(result.unconstrained.get(index, ()))
    print(f"{index:4d} {1e3 * residual:6.2f} mm {share:5.0%}  {status}" + (f"  not held: {free}" if free else ""))

# %%
# What to know about the result comes with it, the worst first.

print("\n".join(result.judgement.lines()))
result
