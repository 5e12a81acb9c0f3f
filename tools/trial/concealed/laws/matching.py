"""Triangulation at the level of disparities: noise that shares a window, frozen speckle, rounding."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, uniform_filter

from tools.trial.concealed.laws.law import Law, lottery, memory_of, noisier
from tools.trial.concealed.rays import blocked
from tools.trial.concealed.shot import Place, Shot

Array = NDArray[np.float64]

BASELINE = 0.075  # [m], the projector on the left


@dataclass(frozen=True)
class Matching:
    """Noise and speckle [px of disparity], the windows that share them [px], the step of the rounding [px]."""

    noise: float = 0.0275
    noise_window: int = 2
    speckle: float = 0.022
    speckle_window: int = 5
    step: float = 0.0625
    window: int = 5

    def _disparity(self, shot: Shot, laws: Sequence[Law], frame: int) -> Array:
        d = shot.camera.f * BASELINE / shot.hits.z
        place = Place(shot, frame, np.ones(d.shape))
        more = np.zeros(d.shape)
        for law in laws:
            if law.stage == "disparity":
                more += law.share(place) * law.acts(place)
        return d + more

    def clean(self, shot: Shot, laws: Sequence[Law], frame: int = 0) -> Array:
        """(h, w) depth without noise or rounding."""
        return np.asarray(shot.camera.f * BASELINE / self._disparity(shot, laws, frame))

    def sigma(self, shot: Shot) -> Array:
        """(h, w) standard deviation [m] of the depth of one frame."""
        px = np.hypot(self.noise, self.step / np.sqrt(12))
        return np.asarray(px * shot.hits.z**2 / (shot.camera.f * BASELINE))

    def record(self, shot: Shot, laws: Sequence[Law], rng: np.random.Generator) -> tuple[Array, None]:
        """Depth (n, h, w) [m], 0 where invalid; no amplitude."""
        shape = shot.hits.z.shape
        projector = (shot.T @ [-BASELINE, 0, 0, 1])[:3]
        lost = blocked(shot.panels, shot.hits, projector) | (shot.hits.panel < 0)
        frozen = self.speckle * _shared(rng, shape, self.speckle_window)
        place = Place(shot, 0, np.ones(shape))
        noisy, memory = noisier(laws, place), memory_of(laws)
        frames: list[Array] = []
        d = None
        for i in range(len(shot.times)):
            if d is None or shot.long:
                d = np.nan_to_num(self._disparity(shot, laws, i))
                wide = maximum_filter(d, self.window)
                d = np.where(wide - d > 1.0, wide, d)  # the nearer surface wins the window
            own = np.round((d + frozen + noisy * self.noise * _shared(rng, shape, self.noise_window)) / self.step)
            z = shot.camera.f * BASELINE / np.maximum(own * self.step, self.step)
            if memory and frames:
                z = (1 - memory) * z + memory * np.where(frames[-1] > 0, frames[-1], z)
            frames.append(np.where(lost | lottery(laws, place, rng), 0.0, z))
        return np.array(frames), None


def _shared(rng: np.random.Generator, shape: tuple[int, ...], window: int) -> Array:
    """A random field of unit spread whose pixels share squares of `window` px."""
    return np.asarray(window * uniform_filter(rng.standard_normal(shape), window, mode="wrap"))
