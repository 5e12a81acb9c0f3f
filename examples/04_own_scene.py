"""
A scene of your own
===================

A cylinder and a box on a table, described in a file, seen by three sensors. Meshes can be any that you have; here one
is made on the spot.
"""

import json
import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import trimesh

import fusion

place = Path(tempfile.mkdtemp())
cylinder = trimesh.creation.cylinder(radius=0.05, height=0.2, sections=64)
cylinder.apply_translation([0, 0, 0.1])
fusion.write_mesh(place / "cylinder.ply", fusion.Mesh.from_trimesh(cylinder))
scene_file = {
    "mesh": "cylinder.ply",
    "reflectance": 0.6,
    "parts": [
        {"box": [[-0.5, -0.6, -0.02], [0.4, 0.6, 0.0]], "reflectance": 0.4},
        {"box": [[-0.1, 0.1, 0.0], [0.05, 0.2, 0.12]], "reflectance": 0.15},
    ],
    "trajectory": {"T_world_camera": {"eye": [0.8, 0.1, 0.45], "target": [0, 0.05, 0.08]}, "frames": 1},
}
(place / "scene.json").write_text(json.dumps(scene_file, indent=1))
scene = fusion.read_scene(place / "scene.json")

# %%
# The same scene, sensor and seed give the same bits. Structured light has no depth in the projector's shadow, beside
# each thing; stereo makes things fat; time of flight hangs on how much light comes back, and by which ways.

camera = fusion.Camera(320, 240, fx=520, fy=520, cx=159.5, cy=119.5)
names = ("kinect-v1", "realsense-d435", "kinect-v2-indoors")
scene = replace(scene, camera=camera)
truth = next(iter(fusion.simulate(scene).frames())).depth
figure, axes = plt.subplots(1, 3, figsize=(12, 3.1), sharey=True, layout="constrained")
for ax, name in zip(axes, names, strict=True):
    frame = next(iter(fusion.simulate(scene, fusion.read_sensor(name), seed=3).frames()))
    shown = ax.imshow(1e3 * (frame.depth - truth), cmap="RdBu_r", vmin=-10, vmax=10)
    ax.set_title(f"{name}, {np.isfinite(frame.depth).mean():.0%} valid")
    ax.set_facecolor("0.6")
figure.colorbar(shown, ax=axes, label="error [mm]; grey: no depth")

# %%
# As a recording, with the truth beside it, it goes through every command.

fusion.write_simulation(place / "rec", fusion.simulate(scene, fusion.read_sensor("kinect-v1"), seed=3))
print(*sorted(path.name for path in (place / "rec").iterdir()))
