"""Per-pixel statistics of a series of images, frame by frame: the memory does not depend on the number of frames."""

import numpy as np
from numpy.typing import NDArray


class PixelSeries:
    """Count, mean and standard deviation of every pixel over the frames added; missing values (NaN) are left out."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.frames = 0
        self.count = np.zeros(shape, np.int32)
        self._mean = np.zeros(shape)
        self._squares = np.zeros(shape)

    def add(self, image: NDArray[np.floating]) -> None:
        """One more frame, NaN where missing (Welford's update, so that no digits are lost at large means)."""
        known = np.isfinite(image)
        self.frames += 1
        self.count += known
        difference = np.where(known, image - self._mean, 0.0)
        self._mean += difference / np.maximum(self.count, 1)
        self._squares += difference * np.where(known, image - self._mean, 0.0)

    @property
    def mean(self) -> NDArray[np.float64]:
        """NaN where no frame had a value."""
        return np.where(self.count > 0, self._mean, np.nan)

    @property
    def std(self) -> NDArray[np.float64]:
        """Standard deviation of one frame; NaN below two values."""
        return np.where(self.count > 1, np.sqrt(self._squares / np.maximum(self.count - 1, 1)), np.nan)

    @property
    def valid(self) -> NDArray[np.float64]:
        """Share of the frames in which the pixel had a value."""
        return self.count / max(self.frames, 1)
