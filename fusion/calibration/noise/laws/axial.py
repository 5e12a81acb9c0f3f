"""The axial law: which form, its numbers with their intervals, and what could not be seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.laws.axial_forms import POLYNOMIAL, AxialForm, Places, candidates, places_of
from fusion.calibration.noise.laws.fit import Data, NoiseFit, choose, fit_law
from fusion.calibration.noise.poses import Pose
from fusion.calibration.noise.visible import VisibleParameters, visible
from fusion.errors import FusionError
from fusion.geometry.principle import Principle
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor

LEAST_VALID = 0.05  # share of values: fewer say which noise is let through, not which there is

Array = NDArray[np.floating]


@dataclass(frozen=True)
class AxialLaw:
    """Axial noise over depth and tilt.

    Attributes:
        poses: that were used.
        sigma, sigma_std: (n,) their noise [m] and how well it is known.
        places: of these poses.
        fits: every form that competed; `chosen` is the index of the one in use.
        visible: what the poses can show.
        kept: parameters that stay as the sensor model had them.
    """

    poses: list[Pose]
    sigma: Array
    sigma_std: Array
    places: Places
    fits: list[NoiseFit]
    chosen: int
    visible: VisibleParameters
    kept: dict[str, float]

    @property
    def best(self) -> NoiseFit:
        """The form in use."""
        return self.fits[self.chosen]

    @property
    def form(self) -> AxialForm:
        """Of the fit in use."""
        form = self.best.form
        assert isinstance(form, AxialForm)
        return form

    @property
    def effect(self) -> AxialNoise:
        """As the sensor model holds it."""
        return self.form.effect(self.best.numbers)

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of each fitted number."""
        return dict(zip(self.form.names, (float(x) for x in self.best.std), strict=True))

    def at(self, depth: Array, tilt: Array) -> tuple[Array, Array]:
        """The law [m] at other distances [m] and tilts [rad], and half its 90 % interval; amplitudes as were seen."""
        depth, tilt = np.broadcast_arrays(np.asarray(depth, float), np.asarray(tilt, float))
        near = np.abs(np.log(depth.reshape(-1, 1) / self.places.depth)) + np.abs(tilt.reshape(-1, 1) - self.places.tilt)
        nearest = near.argmin(axis=1)
        ir = self.places.ir[nearest] * (self.places.depth[nearest] / depth.ravel()) ** 2
        places = Places(depth.ravel(), tilt.ravel(), ir, np.ones(depth.size), self.places.focal_baseline)
        value, std = self.best.predict_with_std(self.form.at(places))
        return value.reshape(depth.shape), (self.best.half_width() * std).reshape(depth.shape)


def axial_law(poses: list[Pose], principle: Principle, known: Sensor, focal_baseline: float) -> AxialLaw:
    """Fit the forms of this kind of sensor and choose by held-out poses.

    Args:
        poses: of a target.
        principle: of the sensor.
        known: the model so far: numbers that these poses cannot show stay as its axial_noise has them.
        focal_baseline: disparity times depth [px m].
    Raises:
        FusionError: not one pose has a noise.
    """
    # a noise that is not above its own deviation lies below the rounding
    some = [p for p in poses if p.axial > p.axial_std > 0 and p.seen.valid >= LEAST_VALID]
    if not some:
        raise FusionError(
            "no pose shows noise",
            found=f"{len(poses)} poses, without repeated values or with equal ones",
            expected="depths that differ between frames by more than their rounding",
            do="record 100 frames at each pose; filters of the camera off",
        )
    sigma, deviation = (np.array([getattr(p, name) for p in some]) for name in ("axial", "axial_std"))
    places = places_of(some, focal_baseline)
    can = visible(places, sigma, np.array([p.lux for p in some]), principle)
    kept = _kept(known, can)
    forms = candidates(places, principle, can.seen, kept)
    fits = [fit_law(form, Data(sigma, deviation)) for form in forms]
    return AxialLaw(some, sigma, deviation, places, fits, choose(fits), can, kept)


def _kept(known: Sensor, can: VisibleParameters) -> dict[str, float]:
    """Hidden parameters of the model's own polynomial law."""
    effect = known.effect("axial_noise")
    if not isinstance(effect, AxialNoise) or np.any(effect.ir_reference):
        return {}
    hidden = [name for name in (*POLYNOMIAL, "angle") if name in can.hidden]
    kept = {name: float(np.mean(getattr(effect, name))) for name in hidden}
    kept = {name: value for name, value in kept.items() if value}
    if "angle" in kept:
        kept["angle_exponent"] = float(np.mean(effect.angle_exponent))
    return kept
