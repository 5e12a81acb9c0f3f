"""The sensor as one model: its effects in light-path order, and all that is derived from them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters
from fusion.sensor.view import BASELINE_M, Image, View

SMALLEST_SIGMA = 1e-5  # [m] weights stay finite for a sensor without noise
CONVERGED = 1e-6  # [m] a tenth of what `correct` promises
MOST_STEPS = 80  # at slope 0.5, the steepest an effect declares, 20 halve 1 m to 1 micrometre; slower ones give up


@dataclass(frozen=True)
class Sensor:
    """What a depth camera does to the truth.

    Attributes:
        name: preset or file.
        principle: "structured_light", "itof", "active_stereo" or "unknown".
        effects: implemented effects, in light-path order.
        sensor, serial: name of the sensor and number of the unit ("" when not known).
        baseline: projector to camera [m], for triangulating sensors.
        std: (effect, parameter) to how well the value is known, in the parameter's unit; 0 exact.
        sources: effect to where its values come from.
        kept: entries of the file that this version knows by name only, as they were read.
        left_out: what the model does not do, one sentence each.
        warnings: what looked wrong while reading, one sentence each.
    """

    name: str = "ideal"
    principle: str = "unknown"
    effects: tuple[Effect, ...] = ()
    sensor: str = ""
    serial: str = ""
    baseline: float = BASELINE_M
    std: dict[tuple[str, str], float] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)
    kept: tuple[dict[str, Any], ...] = ()
    left_out: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        order = {kind: place for place, kind in enumerate(EFFECTS)}
        object.__setattr__(self, "effects", tuple(sorted(self.effects, key=lambda e: order[type(e)])))
        undone = tuple(
            f"{effect.name}: not undone by the correction ({effect.not_undone})"
            for effect in self.effects
            if effect.changes("bias") and effect.not_undone
        )
        object.__setattr__(self, "left_out", (*self.left_out, *(t for t in undone if t not in self.left_out)))

    def effect(self, name: str) -> Effect | None:
        """The effect of that name, or None."""
        return next((effect for effect in self.effects if effect.name == name), None)

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
        return self._sigma(depth, View(camera, depth, incidence, ir=ir, baseline=self.baseline))

    def weight(
        self, depth: Image, incidence: Image | None, camera: Camera, ir: NDArray | None = None
    ) -> NDArray[np.floating]:
        """(1 - dropout) / sigma^2 (h, w) [1/m^2]; 0 where the depth is missing."""
        depth = _floating(depth)
        view = View(camera, depth, incidence, ir=ir, baseline=self.baseline)
        sigma = np.maximum(self.sigma(depth, incidence, camera, ir), SMALLEST_SIGMA)
        with np.errstate(all="ignore"):
            return np.nan_to_num((1.0 - self.dropout(depth, view)) / sigma**2).astype(depth.dtype)

    def dropout(self, depth: Image, view: View) -> Image:
        """Probability (h, w) that a pixel has no value, of all effects together."""
        with np.errstate(all="ignore"):
            seen = np.ones(depth.shape, depth.dtype)
            for effect in self.effects:
                seen = seen * (1.0 - effect.dropout(depth, view))
            return 1.0 - seen

    def predict(self, depth: Image, view: View | Camera) -> NDArray[np.floating]:
        """The mean measured depth (h, w) [m] of a true depth image; NaN stays NaN."""
        depth = _floating(depth)
        self._check_maps(depth.shape)
        view = self._view(view, depth)
        with np.errstate(all="ignore"):
            for effect in self.effects:
                depth = _valid(depth + effect.bias(depth, view)).astype(depth.dtype)
        return depth

    def sample(
        self, depth: Image, view: View | Camera, incidence: Image | None, rng: np.random.Generator
    ) -> NDArray[np.floating]:
        """One measured depth image (h, w) [m] of a true one: biases, noise and dropout drawn from `rng`."""
        depth = _floating(depth)
        self._check_maps(depth.shape)
        view = self._view(view, depth, incidence)
        with np.errstate(all="ignore"):
            for effect in self.effects:
                moved = depth + effect.bias(depth, view) + effect.draw(depth, view, rng)
                if effect.changes("dropout"):
                    moved = np.where(rng.random(depth.shape) < effect.dropout(depth, view), np.nan, moved)
                depth = _valid(moved).astype(depth.dtype)
        return depth

    def correct(self, depth: Image, view: View | Camera) -> NDArray[np.floating]:
        """The true depth (h, w) [m] of a measured one, as far as it can be undone (see `left_out`).

        Solves measured = x + bias(x) effect by effect, last effect first. A pixel without a solution is NaN.
        """
        depth = _floating(depth)
        self._check_maps(depth.shape)
        view = self._view(view, depth)
        with np.errstate(all="ignore"):
            for effect in reversed(self.effects):
                if effect.changes("bias") and not effect.not_undone:
                    depth = _undo(effect, depth, view)
        return depth

    def _sigma(self, depth: Image, view: View) -> NDArray[np.floating]:
        with np.errstate(all="ignore"):
            variance = np.where(np.isfinite(depth), 0.0, np.nan)
            for effect in self.effects:
                variance = variance + effect.noise(depth, view) ** 2
            return np.sqrt(variance).astype(depth.dtype)

    def _view(self, view: View | Camera, depth: Image, incidence: Image | None = None) -> View:
        if isinstance(view, Camera):
            return View(view, depth, incidence, baseline=self.baseline)
        known = incidence if incidence is not None else view.incidence
        return View(view.camera, view.depth, known, view.normals, view.ir, view.color, self.baseline)

    def _check_maps(self, shape: tuple[int, ...]) -> None:
        for effect in self.effects:
            for name in parameters(effect):
                value = np.asarray(getattr(effect, name))
                if value.ndim and value.shape != shape:
                    raise SensorError(
                        f"the map {effect.name}.{name} does not fit the image",
                        self.name,
                        f"{value.shape} values",
                        f"{shape} (height, width)",
                        "use a sensor model of this image size",
                    )


def _undo(effect: Effect, measured: Image, view: View) -> Image:
    """Fixed point x <- measured - bias(x), for one effect."""
    x = measured
    for _ in range(MOST_STEPS):
        better = (measured - effect.bias(x, view)).astype(measured.dtype)
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
    return np.where((depth > 0) & np.isfinite(depth), depth, np.nan)
