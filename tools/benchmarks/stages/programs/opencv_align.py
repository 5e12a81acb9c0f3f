# mypy: ignore-errors
"""OpenCV 5's depth odometry, COMMON (FAST fails half of the object's pairs)."""

import cv2
import numpy as np
from common import load, measure_align

w = load()
cv2.ocl.setUseOpenCL(False)
settings = cv2.OdometrySettings()
settings.setCameraMatrix(w.K.astype(np.float32))
settings.setMaxDepth(w.far)
settings.setMinDepth(0.1)
odometry = cv2.Odometry(cv2.OdometryType_DEPTH, settings, cv2.OdometryAlgoType_COMMON)
metres = [d.astype(np.float32) / 1000 for d in w.depth]


def place(source: int, target: int) -> np.ndarray:
    one, other = cv2.OdometryFrame(metres[source]), cv2.OdometryFrame(metres[target])
    odometry.prepareFrame(one)
    odometry.prepareFrame(other)
    ok, found = odometry.compute(one, other)
    return found if ok else np.eye(4)


measure_align(place, w)
