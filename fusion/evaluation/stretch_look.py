"""All that one still stretch says."""

from dataclasses import dataclass

import numpy as np

from fusion.calibration.noise.target_noise import TargetNoise
from fusion.calibration.shared_noise import COARSE, SharedNoise, centre_of, shared_noise
from fusion.calibration.stretches import Stretch
from fusion.evaluation.bias import Bias
from fusion.evaluation.quantization import Quantization, coarseness
from fusion.evaluation.still.drift import Drift
from fusion.evaluation.still.shares import StretchTiles
from fusion.evaluation.still.statistics import Still
from fusion.evaluation.surface import ExpectedSurface


@dataclass(frozen=True)
class StretchLook:
    """All that one still stretch says."""

    stretch: Stretch  # that was looked at
    still: Still  # statistics per pixel and over time
    surface: ExpectedSurface  # what should be seen
    bias: Bias | None  # None where the surface is not known
    noise: TargetNoise | None  # of the target, None without one or with a single frame
    expected_sigma: float  # what the sensor model says for the target [m], NaN without a model
    drift: Drift  # of the centre
    quantization: Quantization | None  # of this stretch, None where too few levels occur
    reflectance: float  # of the surface as `scene.json` states it, NaN where it does not
    tiles: StretchTiles  # shares, noise and offset in parts of the image
    # valid, missing, outliers: shares in the surface's region; NaN when all of it moves
    valid: float
    missing: float
    outliers: float

    @property
    def name(self) -> str:
        """Of the recording, with the frames where it has several stretches."""
        return self.stretch.name

    @property
    def gap(self) -> float:
        """Usual gap between depths that occur [m]; 0 where it cannot be told."""
        return coarseness(self.still.levels) / self.stretch.recording.camera.depth_scale

    @property
    def coarse(self) -> bool:
        """Whether depths lie so far apart that a pixel's noise is that of its place between two of them."""
        own = np.nan if self.noise is None else self.noise.axial
        return bool(own < COARSE * self.gap)

    @property
    def shared(self) -> SharedNoise:
        """What the pixels of the centre share from frame to frame."""
        sigma = self.still.depth.std[centre_of(self.still.outliers.shape)]
        one = float(np.nanmedian(sigma)) if np.isfinite(sigma).any() else float("nan")
        return shared_noise(self.still.time, self.still.centre, one, self.coarse)

    @property
    def common(self) -> float:
        """Standard deviation of the centre's mean from frame to frame [m]: noise that its pixels share."""
        return self.shared.common
