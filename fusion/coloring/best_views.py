"""The few best views of each vertex, and one colour out of them."""

import numpy as np
from numpy.typing import NDArray

KEPT = 8  # views of a vertex: enough that two or three bad ones are outvoted, few enough to stay sharp (guess)
ALIKE = 20.0  # [counts] views that differ by more from the middle one hardly count: another thing, or a gloss (guess)
BLOCK = 65536  # vertices at once


class BestViews:
    """Colours of each vertex in the views that show it best; memory does not grow with the number of views."""

    def __init__(self, vertices: int) -> None:
        self._weights = np.zeros((vertices, KEPT), np.float32)
        self._colors = np.zeros((vertices, KEPT, 3), np.uint8)

    def add(self, index: NDArray[np.int64], weight: NDArray[np.float32], colors: NDArray[np.float32]) -> None:
        """A view of the vertices `index` (k,), each once, with weights (k,) above 0 and colours (k, 3)."""
        slot = self._weights[index].argmin(axis=1)
        better = weight > self._weights[index, slot]
        index, slot = index[better], slot[better]
        self._weights[index, slot] = weight[better]
        self._colors[index, slot] = np.rint(colors[better])

    def counts(self) -> NDArray[np.int64]:
        """(n,) views that each vertex has its colour from."""
        return np.asarray((self._weights > 0).sum(axis=1))

    def blended(self) -> NDArray[np.float32]:
        """Colours (n, 3): the mean of the views near to the weighted median; 0 where there is none."""
        colors = np.empty((len(self._weights), 3), np.float32)
        for start in range(0, len(colors), BLOCK):
            block = slice(start, start + BLOCK)
            colors[block] = _blended(self._colors[block].astype(np.float32), self._weights[block])
        return colors


def _blended(colors: NDArray[np.float32], weights: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n, 3) from colours (n, views, 3) and weights (n, views), 0 where there is no view."""
    total = weights.sum(axis=1, keepdims=True)
    share = np.asarray(weights / np.where(total > 0, total, 1), np.float32)
    order = colors.argsort(axis=1)
    ordered = np.take_along_axis(colors, order, axis=1)
    below = np.take_along_axis(np.broadcast_to(share[..., None], colors.shape), order, axis=1).cumsum(axis=1)
    half = (below < 0.5).sum(axis=1, keepdims=True).clip(max=colors.shape[1] - 1)
    median = np.take_along_axis(ordered, half, axis=1)
    apart = ((colors - median) ** 2).sum(axis=2)
    trust = share * np.exp(-apart / (2 * ALIKE**2))
    # the median itself counts a little: it need not be near to any view where these disagree in all channels
    little = 1e-3
    mean = (trust[..., None] * colors).sum(axis=1) + little * median[:, 0]
    return np.asarray(mean / (trust.sum(axis=1) + little)[:, None] * (total > 0), np.float32)
