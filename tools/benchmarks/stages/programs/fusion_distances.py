"""fusion's signed distances."""

import numpy as np
from common import Clock, answer, load

from fusion.mesh.comparison.distances import surface_of
from fusion.mesh.mesh import Mesh

w = load()
build: list[float] = []
times: list[float] = []
for _ in range(2):
    with Clock(build):
        surface = surface_of(Mesh(w.vertices, w.faces))
    with Clock(times):
        found = surface.closest(w.points).distances
answer(times={"distances": times, "build": build}, mean_um=float(np.abs(found).mean() * 1e6), signed=True)
