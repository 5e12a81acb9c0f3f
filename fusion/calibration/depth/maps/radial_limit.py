"""How far from the image's middle the corrected depth is as good as there: Pagliari dropped what lies beyond 300 px."""

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.information import WallEvidence
from fusion.calibration.depth.laws.selection import JudgedLaw, level
from fusion.geometry.camera import Camera

RINGS = 10
WORSE = 2.0  # times the median ring: beyond, a pixel weighs less than a fourth


def within(camera: Camera, limit: float) -> NDArray[np.bool_]:
    """(h, w) pixels no farther than `limit` [px] from the principal point."""
    v, u = np.indices(camera.shape)
    return np.hypot(u - camera.cx, v - camera.cy) <= limit


def radial_limit(evidence: list[WallEvidence], judged: JudgedLaw, camera: Camera) -> float | None:
    """Radius [px] beyond which a law leaves twice as much over on walls left out; None when it never does.

    Args:
        evidence: of the walls, in the order of `judged`.
        judged: the law with what it leaves over.
        camera: with the principal point.
    """
    radius, size = [], []
    for e, rest in zip(evidence, judged.residual, strict=True):
        middle = (e.tiles.side - 1) / 2 + e.tiles.side * e.tiles.place
        radius.append(np.hypot(middle[:, 0] - camera.cy, middle[:, 1] - camera.cx))
        # each wall in its own unit of noise, so that a far wall does not decide alone
        size.append(level(e, rest) ** 2 / e.variance)
    r, s = np.concatenate(radius), np.concatenate(size)
    edges = np.linspace(0, r.max() + 1e-9, RINGS + 1)
    ring = np.digitize(r, edges) - 1
    rms = np.array([np.sqrt(s[ring == k].mean()) if (ring == k).sum() >= 4 else np.nan for k in range(RINGS)])
    bad = rms > WORSE * np.nanmedian(rms)
    # only rings at the border: a bad one in the middle is no limit
    outer = RINGS
    while outer > 0 and (bad[outer - 1] or np.isnan(rms[outer - 1])):
        outer -= 1
    return float(edges[outer]) if bad[outer:].any() else None
