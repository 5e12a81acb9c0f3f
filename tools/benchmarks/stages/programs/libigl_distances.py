# mypy: ignore-errors
"""libigl, signed by pseudonormals."""

import igl
import numpy as np
from common import Clock, answer, load

w = load()
times: list[float] = []
with Clock(times):
    found = igl.signed_distance(
        w.points, w.vertices, w.faces.astype(np.int64), sign_type=igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    )[0]
answer(times={"distances": times}, mean_um=float(np.abs(found).mean() * 1e6), signed=True)
