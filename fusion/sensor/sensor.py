"""The sensor as one model: its effects in light-path order, and all that is derived from them."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.geometry.camera import Camera, Principle
from fusion.sensor.depth_errors import DepthErrors
from fusion.sensor.effect import Effect
from fusion.sensor.effects import place_of
from fusion.sensor.effects.light.illumination_vignetting import IR_AT_1M
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.parameter import parameters
from fusion.sensor.view import BASELINE_M, MODULATIONS_HZ, Image, View
from fusion.sensor.working_range import ANY, WorkingRange

SMALLEST_SIGMA = 1e-5  # [m] weights stay finite for a sensor without noise
CONVERGED = 1e-6  # [m] a tenth of what `correct` promises
MOST_STEPS = 80  # at slope 0.5, the steepest an effect declares, 20 halve 1 m to 1 micrometre; slower ones give up


@dataclass(frozen=True)
class Sensor:
    """What a depth camera does to the truth.

    Attributes:
        name: preset or file.
        principle: how it measures; a word of `Principle` is taken too.
        effects: implemented effects, in light-path order.
        sensor, serial: name of the sensor and number of the unit ("" when not known).
        frequencies: modulations of a time-of-flight sensor [Hz]; those of the Kinect v2 where empty.
        baseline: place of the projector on the camera's x axis [m], for triangulating sensors; negative to the left.
        works: between which depths it gives values.
        std: (effect, parameter) to how well the value is known, in the parameter's unit; 0 exact; a list has one
            number for all its values or one for each.
        sources: effect to where its values come from.
        fitted: effects whose numbers were found together on this very unit: they are undone whole, however badly each
            is known by itself, as what one of them has too much the others have too little.
        depth_errors: what the fitted effects may still get wrong together; None where no calibration says it.
        kept: entries of the file that this version knows by name only, as they were read.
        left_out: what the model does not do, one sentence each.
        warnings: what looked wrong while reading, one sentence each.
    """

    name: str = "ideal"
    principle: Principle = Principle.UNKNOWN
    effects: tuple[Effect, ...] = ()
    sensor: str = ""
    serial: str = ""
    baseline: float = BASELINE_M
    frequencies: tuple[float, ...] = ()
    works: WorkingRange = ANY
    std: dict[tuple[str, str], float | tuple[float, ...]] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)
    fitted: frozenset[str] = frozenset()
    depth_errors: DepthErrors | None = None
    kept: tuple[dict[str, Any], ...] = ()
    left_out: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "principle", Principle(self.principle))
        object.__setattr__(self, "effects", tuple(sorted(self.effects, key=place_of)))
        left = tuple(
            f"{effect.name}: not corrected ({why})"
            for effect in self.effects
            if (why := self.why_not_corrected(effect))
        )
        object.__setattr__(self, "left_out", (*self.left_out, *(t for t in left if t not in self.left_out)))

    def __repr__(self) -> str:
        names = ", ".join(effect.name for effect in self.effects)
        return f"<Sensor {self.name}: {self.principle}; {names or 'no effects'}>"

    def effect(self, name: str) -> Effect | None:
        """The effect of that name, or None."""
        return next((effect for effect in self.effects if effect.name == name), None)

    def having(self, effect: Effect) -> "Sensor":
        """This sensor with an effect in place of its own of that name, or in addition."""
        others = tuple(own for own in self.effects if own.name != effect.name)
        known = None if effect.name in self.fitted else self.depth_errors
        fitted = self.fitted - {effect.name}
        return replace(self, effects=(*others, effect), fitted=fitted, depth_errors=known, left_out=())

    def why_not_corrected(self, effect: Effect) -> str:
        """Why the correction leaves an effect of this sensor; empty when it undoes it."""
        if not effect.changes("bias") or effect.why_not_corrected():
            return effect.why_not_corrected()
        return self.usual(effect)

    def usual(self, effect: Effect) -> str:
        """Why an effect of this sensor is not known for this very unit; empty when it is."""
        for name in parameters(effect) if effect.name not in self.fitted else ():
            size = float(np.abs(getattr(effect, name)).max())
            # undoing what is known no better than its own size makes things worse on most units
            if 0 < size <= float(np.max(self.std.get((effect.name, name), 0.0))):
                return f"its {name} is a usual one, not known for this unit: calibrate it"
        return ""

    def sigma(
        self, depth: Image, incidence: Image | None, camera: Camera, ir: NDArray | None = None
    ) -> NDArray[np.floating]:
        """Standard deviation (h, w) [m] of a depth image (h, w) [m]; NaN where the depth is missing.

        Args:
            incidence: (h, w) angle of ray and normal [rad]; None or NaN counts as frontal.
            ir: (h, w) amplitude [count], where the sensor's noise follows it.
        """
        depth = _floating(depth)
        self._check_maps(depth.shape)
        return self._sigma(depth, self._view(View(camera, depth, incidence, ir=ir), depth))

    def weight(
        self, depth: Image, incidence: Image | None, camera: Camera, ir: NDArray | None = None
    ) -> NDArray[np.floating]:
        """(1 - dropout) / sigma^2 (h, w) [1/m^2]; 0 where the depth is missing."""
        depth = _floating(depth)
        view = self._view(View(camera, depth, incidence, ir=ir), depth)
        sigma = np.maximum(self.sigma(depth, incidence, camera, ir), SMALLEST_SIGMA)
        with np.errstate(all="ignore"):
            return np.nan_to_num((1.0 - self.doubt(depth, view)) / sigma**2).astype(depth.dtype)

    def repeated(self, depth: Image, view: View) -> tuple[Image, Image]:
        """Mean and standard deviation (h, w) [m] of repeated frames of a true depth image: what is frozen repeats."""
        mean, view = _floating(depth), self._view(view, depth)
        self._check_maps(mean.shape)
        sigma = np.where(np.isfinite(mean), np.zeros((), mean.dtype), np.nan)
        with np.errstate(all="ignore"):
            for effect in self.effects:
                if effect.name not in view.done:
                    mean, sigma = effect.repeated(mean, sigma, view)
                    mean = _valid(mean)
        return mean, sigma

    def dropout(self, depth: Image, view: View) -> Image:
        """Probability (h, w) that a pixel has no value, of all effects together, and outside the working range."""
        lost = self.doubt(depth, view)
        with np.errstate(all="ignore"):
            missed = self.works.misses(depth)
        return np.where(missed, np.ones((), lost.dtype), lost) if missed.any() else lost

    def doubt(self, depth: Image, view: View) -> Image:
        """The same (h, w) of the effects alone, which is what speaks against a value that is there."""
        view = self._view(view, depth)
        with np.errstate(all="ignore"):
            seen = np.ones((), depth.dtype)
            for effect in self.effects:
                if effect.changes("dropout"):
                    seen = seen * (1 - effect.dropout(depth, view))
            return np.broadcast_to(1 - seen, depth.shape)

    def amplitude(self, view: View) -> Image | None:
        """The amplitude (h, w) [count] that a view sends back; None where its reflectance or depth is not known.

        reflectance * cos(incidence) / range^2, then what each effect does to the light on its way.
        """
        if view.reflectance is None or view.depth is None:
            return None
        with np.errstate(all="ignore"):
            light = np.square(view.depth * view.stretch)
            light = np.divide(IR_AT_1M * view.reflectance, light, out=light)
            if view.incidence is not None:
                light *= np.cos(view.incidence)
            for effect in self.effects:
                if effect.changes("light"):
                    light = effect.light(light, view.depth, view)
            return light.astype(view.depth.dtype, copy=False)

    def predict(self, depth: Image, view: View | Camera) -> NDArray[np.floating]:
        """The mean measured depth (h, w) [m] of a true depth image; NaN stays NaN."""
        depth = _floating(depth)
        self._check_maps(depth.shape)
        view = self._view(view, depth)
        with np.errstate(all="ignore"):
            for effect in self.effects:
                if effect.changes("bias") and effect.name not in view.done:
                    depth = _valid(depth + effect.change(depth, view)).astype(depth.dtype)
        return depth

    def sample(
        self, depth: Image, view: View | Camera, incidence: Image | None, rng: np.random.Generator
    ) -> NDArray[np.floating]:
        """One measured depth image (h, w) [m] of a true one: biases, noise and dropout drawn from `rng`."""
        depth = _floating(depth)
        self._check_maps(depth.shape)
        view = self._view(view, depth, incidence)
        seen = np.ones((), depth.dtype)
        with np.errstate(all="ignore"):
            for effect in self.effects:
                if effect.name in view.done:
                    continue
                if effect.changes("dropout"):
                    seen = seen * (1 - effect.dropout(depth, view))
                if effect.changes("bias") or effect.changes("noise"):
                    depth = _valid(effect.sampled(depth, view, rng)).astype(depth.dtype, copy=False)
        if seen.ndim or seen < 1:
            depth = np.where(rng.random(depth.shape, dtype=depth.dtype.type) < seen, depth, depth.dtype.type(np.nan))
        with np.errstate(all="ignore"):
            missed = self.works.misses(depth)
        return np.where(missed, depth.dtype.type(np.nan), depth) if missed.any() else depth

    def correct(self, depth: Image, view: View | Camera) -> NDArray[np.floating]:
        """The true depth (h, w) [m] of a measured one, as far as it can be undone (see `left_out`).

        Solves measured = x + bias(x) effect by effect, last effect first. A pixel without a solution is NaN.
        """
        depth = _floating(depth)
        self._check_maps(depth.shape)
        view = self._view(view, depth)
        with np.errstate(all="ignore"):
            for effect in reversed(self.effects):
                if effect.changes("bias") and not self.why_not_corrected(effect):
                    depth = _corrected(effect, depth, view)
        return depth

    def true_camera(self, stated: Camera) -> Camera:
        """The camera that took the pictures: the stated one without the errors that the model holds."""
        for effect in self.effects:
            if isinstance(effect, CameraEffect):
                stated = effect.true_camera(stated)
        return stated

    def _sigma(self, depth: Image, view: View) -> NDArray[np.floating]:
        with np.errstate(all="ignore"):
            sigma = np.where(np.isfinite(depth), np.zeros((), depth.dtype), np.nan)
            for effect in self.effects:
                sigma = effect.spread(sigma, depth, view)
            return sigma.astype(depth.dtype)

    def seen(self, view: View) -> View:
        """A view with what this sensor adds to it: its baseline, principle, and its amplitude where none is known."""
        assert view.depth is not None
        return self._view(view, view.depth)

    def _view(self, view: View | Camera, depth: Image, incidence: Image | None = None) -> View:
        if isinstance(view, Camera):
            view = View(view, depth)
        view = replace(
            view,
            depth=depth if view.depth is None else view.depth,
            incidence=view.incidence if incidence is None else incidence,
            baseline=self.baseline,
            frequencies=self.frequencies or (MODULATIONS_HZ if self.principle == Principle.TIME_OF_FLIGHT else ()),
            principle=view.principle.or_else(self.principle),
        )
        return view if view.ir is not None else replace(view, ir=self.amplitude(view))

    def _check_maps(self, shape: tuple[int, ...]) -> None:
        for effect in self.effects:
            for name, about in parameters(effect).items():
                value = np.asarray(getattr(effect, name))
                if value.ndim and about.kind in ("number", "map") and value.shape != shape:
                    raise SensorError(
                        f"the map {effect.name}.{name} does not fit the image",
                        self.name,
                        f"{value.shape} values",
                        f"{shape} (height, width)",
                        "use a sensor model of this image size",
                    )


def _corrected(effect: Effect, measured: Image, view: View) -> Image:
    """In closed form, or the fixed point x <- measured - bias(x), for one effect."""
    closed = effect.corrected(measured, view)
    if closed is not None:
        return _valid(closed)
    x = measured
    for _ in range(MOST_STEPS):
        better = (measured - effect.change(x, view)).astype(measured.dtype)
        change = np.abs(better - x)
        x = better
        # beyond 8 m a float32 cannot tell 1 micrometre apart
        far = change > np.maximum(CONVERGED, 4 * np.finfo(x.dtype).eps * np.abs(x))
        if not far.any():
            break
    else:
        x = np.where(far, np.nan, x)
    return _valid(x)


def _floating(depth: Image) -> Image:
    depth = np.asarray(depth)
    return depth if np.issubdtype(depth.dtype, np.floating) else depth.astype(np.float32)


def _valid(depth: Image) -> Image:
    """A depth of 0 or less, or infinite, is no depth."""
    if np.fmin.reduce(depth, axis=None) > 0 and np.fmax.reduce(depth, axis=None) < np.inf:  # NaN aside
        return depth
    return np.where((depth > 0) & np.isfinite(depth), depth, np.nan)
