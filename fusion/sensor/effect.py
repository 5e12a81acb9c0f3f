"""A sensor effect: at most three pure functions of the true depth and of what a pixel looked at."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class Effect:
    """One physical cause of error; a subclass holds its parameters and overrides what it changes.

    All three functions take the depth (h, w) [m] as it arrives at this place of the light path, NaN where
    missing, and return something that broadcasts to (h, w).
    """

    name: ClassVar[str] = ""
    key: ClassVar[str] = ""  # of the equation in the catalogue
    principles: ClassVar[tuple[str, ...]] = ()  # sensors that can have it; empty = all
    not_undone: ClassVar[str] = ""  # why `correct` leaves it; empty when it is undone
    frozen: ClassVar[bool] = False  # noise is the spread of its own bias: never drawn a second time

    def bias(self, depth: Image, view: View) -> Image:
        """Change of the mean depth [m]."""
        return np.zeros((), depth.dtype)

    def noise(self, depth: Image, view: View) -> Image:
        """Standard deviation of the depth [m]."""
        return np.zeros((), depth.dtype)

    def dropout(self, depth: Image, view: View) -> Image:
        """Probability that the pixel has no value [1]."""
        return np.zeros((), depth.dtype)

    def draw(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        """One draw (h, w) [m] with mean 0 and the standard deviation `noise`; normal unless overridden."""
        if self.frozen or not self.changes("noise"):
            return np.zeros((), depth.dtype)
        return self.noise(depth, view) * rng.standard_normal(depth.shape)

    @classmethod
    def changes(cls, channel: str) -> bool:
        """True when the effect has its own "bias", "noise" or "dropout"."""
        return getattr(cls, channel) is not getattr(Effect, channel)
