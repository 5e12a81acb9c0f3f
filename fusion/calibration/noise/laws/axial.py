"""The axial law: which form, its numbers with their intervals, and what could not be seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.laws.axial_forms import POLYNOMIAL, AxialForm, Places, candidates, places_of
from fusion.calibration.noise.laws.fit import Data, NoiseFit, choose, fit_law
from fusion.calibration.noise.poses import Pose
from fusion.errors import FusionError
from fusion.geometry.camera import Principle
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.sensor import Sensor

LEAST_VALID = 0.05  # share of values: fewer say which noise is let through, not which there is
Array = NDArray[np.floating]
APART = 0.06  # share of the depth: nearer ones are one distance
STEEP = np.deg2rad(40)  # below it the angle term is a few per cent of the noise
RATIO = 1.4  # farthest over nearest distance of tilted targets that tell the power of z
SUNNY_LUX, SUNNY = 15_000.0, 0.006  # [lux]; [1/m] noise over z^2 that no room makes: four times the overcast law's


@dataclass(frozen=True)
class VisibleParameters:
    """Parameters of axial_noise that can be seen, and for those that cannot what to record."""

    seen: frozenset[str]
    hidden: dict[str, str]


def visible(
    places: Places, sigma: NDArray[np.floating], lux: NDArray[np.floating], principle: Principle
) -> VisibleParameters:
    """Judge the places (n,) with their noise [m] and the stated light [lux], NaN where it is not stated."""
    distances, seen, hidden = count_apart(places.depth), {"c0"}, {}
    ways = "a target at six or more distances from the nearest to the farthest in use"
    numbers = len(places.depth)
    if distances >= 3 and numbers >= 5:
        seen |= {"c1", "c2"}
    elif distances == 2 and numbers >= 3:
        seen |= {"c2"}
        hidden["c1"] = f"{ways} (these are at 2)"
    else:
        hidden |= dict.fromkeys(("c1", "c2"), f"{ways} (these are at {distances})")
    steep = places.tilt >= STEEP
    if steep.any() and numbers >= len(seen) + 2:
        seen.add("angle")
        z = places.depth[steep]
        if count_apart(z) >= 2 and np.max(z) > RATIO * np.min(z):
            seen.add("angle_exponent")
        else:
            hidden["angle_exponent"] = "the target turned to 60 and 75 deg at a near and at a far distance"
    else:
        most = float(np.rad2deg(np.max(places.tilt)))
        hidden["angle"] = (
            f"the target turned to 45, 60 and 75 deg at two or more distances (at most {most:.0f} deg now)"
        )
    sunny = np.nanmax(lux, initial=0.0) > SUNNY_LUX or float(np.median(sigma / places.depth**2)) > SUNNY
    if principle == Principle.TIME_OF_FLIGHT and sunny:
        if {"c2", "angle"} <= seen and count_apart(1.0 + places.tilt) >= 3:
            seen.add("sunlight")
        else:
            hidden["sunlight"] = "the target in the sun at three or more angles from 0 to 75 deg"
    return VisibleParameters(frozenset(seen), hidden)


def count_apart(values: NDArray[np.floating]) -> int:
    """How many values there are that differ by more than 6 %."""
    ordered = np.sort(values)
    return int(1 + (np.diff(ordered) > APART * ordered[:-1]).sum()) if len(values) else 0


@dataclass(frozen=True)
class AxialLaw:
    """Axial noise over depth and tilt."""

    poses: list[Pose]  # that were used
    # sigma, sigma_std: (n,) their noise [m] and how well it is known
    sigma: Array
    sigma_std: Array
    places: Places  # of these poses
    fits: list[NoiseFit]  # every form that competed; `chosen` is the index of the one in use
    chosen: int
    visible: VisibleParameters  # what the poses can show
    kept: dict[str, float]  # parameters that stay as the sensor model had them

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
