"""Missing values: where they go with too little light, an amplitude dropout; else only their shares are told."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import curve_fit
from scipy.special import expit

from fusion.calibration.noise.poses import Pose
from fusion.sensor.effects.readout.amplitude_dropout import AmplitudeDropout

SOME = (0.02, 0.98)  # shares of missing values that say where the threshold is
FEWEST = 3  # such poses
SHARE_STD = 0.02  # of a pose's share: amplitudes differ over the target, guess
LEFT = 0.1  # of the variance between the poses that the law may leave over

Array = NDArray[np.floating]


@dataclass(frozen=True)
class DropoutLaw:
    """The share of missing values over the amplitude.

    Attributes:
        ir, missing: (n,) amplitude [count] and share of each pose.
        numbers, std: threshold and width [count].
    """

    ir: Array
    missing: Array
    numbers: tuple[float, float]
    std: tuple[float, float]

    @property
    def effect(self) -> AmplitudeDropout:
        """As the sensor model holds it."""
        return AmplitudeDropout(ir_threshold=self.numbers[0], width=self.numbers[1])

    def predict(self, ir: Array) -> Array:
        """Share of missing values at amplitudes [count]."""
        return np.asarray(expit((self.numbers[0] - ir) / self.numbers[1]))


def dropout_law(poses: list[Pose]) -> DropoutLaw | None:
    """None unless the data show it: enough poses at which some values are missing, fewer where there is more light."""
    ir, missing = np.array([[p.ir, p.seen.no_data] for p in poses]).reshape(-1, 2).T
    known = np.isfinite(ir) & (ir > 0)
    ir, missing = ir[known], missing[known]
    if ((missing > SOME[0]) & (missing < SOME[1])).sum() < FEWEST:
        return None
    order = np.argsort(missing)
    middle = float(np.interp(0.5, missing[order], ir[order]))
    try:
        found, covariance = curve_fit(
            lambda x, threshold, width: expit((threshold - x) / width),
            ir,
            missing,
            (middle, 0.2 * middle),
            sigma=np.full(len(ir), SHARE_STD),
            bounds=((0, 1e-3 * middle), (1e5, 1e5)),
        )
    except (RuntimeError, ValueError):
        return None
    law = DropoutLaw(ir, missing, (float(found[0]), float(found[1])), tuple(np.sqrt(np.diag(covariance)).tolist()))
    rest = missing - law.predict(ir)
    return law if rest.var() <= LEFT * missing.var() else None
