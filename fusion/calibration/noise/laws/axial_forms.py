"""The laws of axial noise that compete: those of the axial_noise effect, each with some of its parameters free."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.poses import Pose
from fusion.geometry.camera import Principle
from fusion.sensor.effects.readout.axial_noise import STEEPEST, AxialNoise

Array = NDArray[np.floating]

EXPONENTS = {"Fankhauser": 1.5, "Nguyen": -0.5}  # power of z in the angle term
POLYNOMIAL = ("c0", "c1", "c2")


@dataclass(frozen=True)
class Places:
    """Where noise was measured, or is asked for; all (n,)."""

    depth: Array  # [m]
    tilt: Array  # [rad]
    ir: Array  # amplitude [count], NaN when not known
    stretch: Array  # length of the ray per metre of depth [1]
    focal_baseline: float  # disparity times depth [px m]

    def part(self, which: NDArray[np.bool_]) -> "Places":
        """Some of them."""
        return replace(
            self, depth=self.depth[which], tilt=self.tilt[which], ir=self.ir[which], stretch=self.stretch[which]
        )

    @property
    def steepness(self) -> Array:
        """theta^2 / (pi/2 - theta)^2, held where the effect holds it."""
        theta = np.minimum(self.tilt, STEEPEST)
        return np.asarray((theta / (np.pi / 2 - theta)) ** 2)


def places_of(poses: list[Pose], focal_baseline: float) -> Places:
    """The places of poses."""
    depth, tilt, ir, stretch = np.array([(p.depth, p.tilt, p.ir, p.stretch) for p in poses], float).reshape(-1, 4).T
    return Places(depth, tilt, ir, stretch, focal_baseline)


@dataclass(frozen=True)
class AxialForm:
    """An axial_noise effect with some parameters free at some places."""

    title: str  # for a person
    names: tuple[str, ...]  # free parameters of the effect
    places: Places  # where
    fixed: dict[str, float] = field(default_factory=dict)  # parameters that are not fitted

    def part(self, which: NDArray[np.bool_]) -> "AxialForm":
        """The same at some of the places."""
        return replace(self, places=self.places.part(which))

    def at(self, places: Places) -> "AxialForm":
        """The same at other places."""
        return replace(self, places=places)

    def bounds(self) -> tuple[Array, Array]:
        """c0 to c2 may be negative; what is a spread is not, nor is c0 where its square joins that of the disparity."""
        signed = () if "sigma_px" in self.names else POLYNOMIAL
        low = [-1.0 if name in signed else -3.0 if name == "angle_exponent" else 0.0 for name in self.names]
        high = [3.0 if name == "angle_exponent" else 10.0 if name == "sigma_px" else 1.0 for name in self.names]
        return np.array(low), np.array(high)

    def start(self, sigma: Array) -> Array:
        """A constant, and a little of everything else."""
        usual = {"c0": float(np.median(sigma)), "angle": 1e-4, "angle_exponent": 0.5, "sunlight": 1e-4}
        usual |= {"sigma_px": float(np.median(sigma / self.places.depth**2)) * self.places.focal_baseline}
        usual |= {"shot": float(np.median(sigma)), "floor": float(np.median(sigma))}
        return np.array([usual.get(name, 0.0) for name in self.names])

    def predict(self, numbers: Array) -> Array:
        """(n,) [m]; as AxialNoise.noise, without its bound at 0."""
        p = self.fixed | dict(zip(self.names, (float(x) for x in numbers), strict=True))
        z = self.places.depth
        if "ir_reference" in p:
            q = p["ir_reference"] / np.maximum(self.places.ir, 1e-9)
            shape = np.sqrt(q * (p.get("shot", 0.0) ** 2 + p.get("floor", 0.0) ** 2 * q)) / self.places.stretch
        else:
            shape = p.get("c0", 0.0) + z * (p.get("c1", 0.0) + p.get("c2", 0.0) * z)
            shape = shape + p.get("angle", 0.0) * z ** p.get("angle_exponent", 1.5) * self.places.steepness
            shape = shape + p.get("sunlight", 0.0) * z**2 * np.cos(np.minimum(self.places.tilt, STEEPEST))
        if "sigma_px" in p:
            shape = np.hypot(shape, p["sigma_px"] / self.places.focal_baseline * z**2)
        return np.asarray(shape)

    def effect(self, numbers: Array) -> AxialNoise:
        """The effect with these numbers."""
        values: dict[str, Any] = self.fixed | {n: float(x) for n, x in zip(self.names, numbers, strict=True)}
        return AxialNoise(**values)


def candidates(places: Places, principle: Principle, seen: frozenset[str], fixed: dict[str, float]) -> list[AxialForm]:
    """The laws that compete for these places.

    Args:
        seen: parameters that the places can show.
        fixed: parameters that they cannot show and that are known otherwise.
    """
    polynomial = tuple(name for name in POLYNOMIAL if name in seen)
    forms = []
    if "angle" in seen:
        usual = "Fankhauser" if principle == Principle.TIME_OF_FLIGHT else "Nguyen"
        for name, power in EXPONENTS.items():
            if "angle_exponent" not in seen and name != usual:
                continue  # one distance cannot tell them apart
            about = f"polynomial in z, angle term of {name}"
            forms.append(AxialForm(about, (*polynomial, "angle"), places, fixed | {"angle_exponent": power}))
        if "angle_exponent" in seen:
            names = (*polynomial, "angle", "angle_exponent")
            forms.append(AxialForm("polynomial in z, angle term of any power", names, places, fixed))
    else:
        forms.append(AxialForm("polynomial in z", polynomial, places, fixed))
    if "sunlight" in seen:
        forms += [
            replace(form, title=form.title + ", sunlight", names=(*form.names, "sunlight"))
            for form in forms
            if "angle_exponent" not in form.names
        ]
    if principle != Principle.TIME_OF_FLIGHT and "c2" in seen:
        forms += _of_disparity(places, seen, fixed)
    if (
        principle == Principle.TIME_OF_FLIGHT
        and np.isfinite(places.ir).all()
        and np.ptp(np.log(np.maximum(places.ir, 1.0))) > 0.5
    ):
        reference = {"ir_reference": float(np.median(places.ir))}
        forms.append(AxialForm("light that comes back: shot noise and floor", ("shot", "floor"), places, reference))
    return forms


def _of_disparity(places: Places, seen: frozenset[str], fixed: dict[str, float]) -> list[AxialForm]:
    """A spread of the disparity and a constant, in place of the polynomial."""
    if "angle" not in seen:
        return [AxialForm("spread of the disparity", ("c0", "sigma_px"), places, fixed)]
    power = {"angle_exponent": EXPONENTS["Nguyen"]}
    title = "spread of the disparity, angle term of Nguyen"
    return [AxialForm(title, ("c0", "angle", "sigma_px"), places, fixed | power)]
