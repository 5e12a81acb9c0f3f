"""
Compare a scan with a drawing
=============================

A ball of 100 mm and a box as a scanner may give them: 0.2 mm of noise, 0.4 % too large, with a dent of 1.5 mm, lying
anywhere. Which of these does the comparison tell apart?
"""

import matplotlib.pyplot as plt
import numpy as np
import trimesh

import fusion

drawing = fusion.Mesh.from_trimesh(trimesh.creation.icosphere(subdivisions=5, radius=0.05))
box = fusion.Mesh.from_trimesh(trimesh.creation.box((0.06, 0.04, 0.08)).subdivide().subdivide().subdivide())
drawing = fusion.Mesh(  # a ball with a box beside it: a ball alone looks the same however it lies
    np.concatenate([drawing.vertices, box.vertices + np.array([0.09, 0, 0])]),
    np.concatenate([drawing.faces, box.faces + len(drawing.vertices)]),
)

rng = np.random.default_rng(1)
outwards = trimesh.Trimesh(drawing.vertices, drawing.faces, process=False).vertex_normals
dented = np.linalg.norm(drawing.vertices - np.array([0, 0, 0.05]), axis=1) < 0.02  # at the ball's top
moved = rng.normal(0, 0.2e-3, len(drawing.vertices)) - 1.5e-3 * dented
vertices = 1.004 * (drawing.vertices + moved[:, None] * outwards)
turn = trimesh.transformations.rotation_matrix(0.3, [1, 2, 3])[:3, :3]
scan = fusion.Mesh(vertices @ turn.T + np.array([0.02, 0.01, 0.3]), drawing.faces)

# %%
# With a scale
# ------------
# The scale is found, and noise and dent are left. The picture shows where: blue lies too far in.

found = fusion.compare(scan, drawing, fusion.CompareSettings(scale=True))
print(found)
found.mesh

# %%
# Without one
# -----------
# An error of size then looks like an error of shape: the far ends stand out on all sides.

for name, scale in (("scale found", True), ("as it is", False)):
    one = fusion.compare(scan, drawing, fusion.CompareSettings(scale=scale))
    distances = 1e3 * one.mesh.scalars["signed_distance"]
    plt.hist(distances, bins=np.linspace(-2, 1, 120), histtype="step", label=f"{name}: {distances.std():.2f} mm")
plt.xlabel("signed distance [mm], positive outside")
plt.ylabel("vertices")
plt.legend()
