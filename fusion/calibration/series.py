"""Per-pixel statistics of a series of images, frame by frame: the memory does not depend on the number of frames."""

import cv2
import numpy as np
from numpy.typing import NDArray


class PixelSeries:
    """Count, mean and standard deviation of every pixel over the frames added; missing values (NaN) are left out."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.frames = 0
        self.count = np.zeros(shape, np.int32)
        self._first: NDArray[np.floating] = np.zeros(shape, np.float32)
        self._sum, self._squares = np.zeros(shape), np.zeros(shape)

    def add(self, image: NDArray) -> None:
        """One more frame, NaN where missing.

        Sums are those of the differences from each pixel's first value, so that no digits are lost at large means.
        """
        known = np.isfinite(image)
        self.frames += 1
        wide = np.float64 if image.dtype == np.float64 else np.float32
        self._first = self._first.astype(wide, copy=False)
        fresh = known & (self.count == 0)
        if fresh.any():
            self._first[fresh] = image[fresh]
        self.count += known
        difference = np.subtract(image, self._first, dtype=wide)
        if not known.all():
            difference[~known] = 0.0
        # OpenCV adds single to double precision in one pass; a colour's channels lie side by side
        rows = (len(difference), -1)
        cv2.accumulate(difference.reshape(rows), self._sum.reshape(rows))
        cv2.accumulateSquare(difference.reshape(rows), self._squares.reshape(rows))

    @property
    def mean(self) -> NDArray[np.float64]:
        """NaN where no frame had a value."""
        return np.where(self.count > 0, self._first + self._sum / np.maximum(self.count, 1), np.nan)

    @property
    def std(self) -> NDArray[np.float64]:
        """Standard deviation of one frame; NaN below two values."""
        squares = self._squares - self._sum**2 / np.maximum(self.count, 1)
        variance = np.maximum(squares, 0.0) / np.maximum(self.count - 1, 1)
        return np.where(self.count > 1, np.sqrt(variance), np.nan)

    @property
    def valid(self) -> NDArray[np.float64]:
        """Share of the frames in which the pixel had a value."""
        return self.count / max(self.frames, 1)
