"""A sensor effect: at most three pure functions of the true depth and of what a pixel looked at.

Bias, noise and dropout are what one observes of a pixel. Two more functions exist because light and noise pass
through an effect: `light` changes the amplitude that arrives, `spread` the noise of everything before it.
Neighbours, edges and history are arguments (the whole image, `View`), never hidden state.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, final

import numpy as np

from fusion.errors import SensorError
from fusion.geometry.camera import Principle
from fusion.sensor.parameter import parameters
from fusion.sensor.view import Image, View
from fusion.sensor.where import Bound, inside


@dataclass(frozen=True)
class Effect:
    """One physical cause of error; a subclass holds its parameters and overrides what it changes.

    All functions take the depth (h, w) [m] as it arrives at this place of the light path, NaN where
    missing, and return something that broadcasts to (h, w), in the type of the depth.

    Attributes:
        where: bounds outside which it does not change the mean; empty: it acts everywhere.

    >>> @dataclasses.dataclass(frozen=True)
    ... class Tilted(fusion.Effect):
    ...     name = "tilted"
    ...     slope: float = fusion.parameter("1", (-0.1, 0.1), "of the error from column to column", "guess")
    ...     def bias(self, depth, view):
    ...         return (self.slope * depth * (view.u - view.camera.cx) / view.camera.fx).astype(depth.dtype)
    >>> sensor, camera = fusion.Sensor(effects=(Tilted(slope=0.01),)), fusion.Camera(64, 48, 60.0, 60.0, 31.5, 23.5)
    >>> measured = sensor.predict(np.full(camera.shape, 1.0, np.float32), camera)
    >>> print(f"{1e3 * (measured[0, -1] - 1):.2f} mm")
    5.25 mm
    """

    name: ClassVar[str] = ""
    key: ClassVar[str] = ""  # of the equation in the catalogue
    formula: ClassVar[str] = ""  # the law as one line of text
    variables: ClassVar[tuple[str, ...]] = ()  # what the law depends on, in the words of the verdict file
    principles: ClassVar[tuple[Principle, ...]] = ()  # sensors that can have it; empty = all
    not_corrected: ClassVar[str] = ""  # why `correct` leaves it; empty when it is undone
    per_frequency: ClassVar[bool] = False  # from the phase at one modulation: `change` is the mean over all of them
    # what holds its bias ("unit", "scene" that stands still, "depth") where noise is the spread of that, and not drawn
    frozen: ClassVar[str] = ""

    # how far apart the only depths lie that it leaves: law of the distance ("constant", "z^2"), and its parameter
    lattice: ClassVar[dict[str, str]] = {}

    grain: ClassVar[tuple[str, ...]] = ()  # parameters of what frozen pixels have each for themselves: size, window
    own: ClassVar[bool] = False  # noise that every sensor has: a model without any is not finished

    where: tuple[Bound, ...] = field(default=(), kw_only=True)

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        # a dataclass keeps what stands in its class; its own comparison fails on arrays, which have no truth value
        for name in ("__eq__", "__hash__"):
            setattr(cls, name, getattr(Effect, name))

    def __post_init__(self) -> None:
        about = parameters(self)
        lengths = {}
        for name, known in about.items():
            value = getattr(self, name)
            if isinstance(value, list | tuple):
                object.__setattr__(self, name, np.asarray(value, float))
            if known.kind == "list" and np.ndim(value):
                lengths[known.label] = len(value)
        if len(set(lengths.values())) > 1:
            found = ", ".join(f"{name}: {length}" for name, length in lengths.items())
            raise SensorError(f"the lists of {self.name} differ in length", found=found, expected="equal lengths")

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(a, b) for a, b in zip(_values(self), _values(other), strict=True))

    def __hash__(self) -> int:
        return hash((type(self), *(v.tobytes() if isinstance(v, np.ndarray) else v for v in _values(self))))

    def bias(self, depth: Image, view: View) -> Image:
        """Change of the mean depth [m]."""
        return np.zeros((), depth.dtype)

    @final
    def change(self, depth: Image, view: View) -> Image:
        """The bias [m] as the sensor gives it: the mean over its modulations, where the phase of each has its own.

        A range from several phases weighs each with the square of its frequency, as equal phase noise makes best.
        """
        whole = self._everywhere(depth, view)
        return np.where(inside(self.where, depth, view), whole, 0).astype(depth.dtype) if self.where else whole

    def _everywhere(self, depth: Image, view: View) -> Image:
        if not self.per_frequency:
            return self.bias(depth, view)
        return np.asarray(over_modulations(lambda one: self.bias(depth, one), view), depth.dtype)

    def corrected(self, measured: Image, view: View) -> Image | None:
        """The depth (h, w) [m] whose biased one is `measured`, where there is a form for it; None: it is searched."""
        return None

    def noise(self, depth: Image, view: View) -> Image:
        """Standard deviation of the depth [m] that this effect adds."""
        return np.zeros((), depth.dtype)

    def dropout(self, depth: Image, view: View) -> Image:
        """Probability that the pixel has no value [1]."""
        return np.zeros((), depth.dtype)

    def loses_with(self, depth: Image, view: View) -> Image | None:
        """What its missing values rise with (h, w), where how they rise is not known: a form that is a guess, or one of
        light that nobody recorded; None where `dropout` says all.
        """
        return None

    def lit_from(self) -> float | None:
        """Place [m] on the camera's x axis from where light must reach what has a value; None where none is asked."""
        return None

    def other_zero(self, view: View) -> "Effect | None":
        """The most by which it may differ where its law has its zero elsewhere, which nobody recorded; None where it is
        known.
        """
        return None

    def light(self, amplitude: Image, depth: Image, view: View) -> Image:
        """The amplitude (h, w) [count] behind this effect; `depth` is the true one."""
        return amplitude

    def spread(self, sigma: Image, depth: Image, view: View) -> Image:
        """Standard deviation (h, w) [m] behind this effect, `sigma` in front of it; independent unless overridden."""
        if not self.changes("noise"):
            return sigma
        return independent(sigma, self.noise(depth, view))

    def repeated(self, mean: Image, sigma: Image, view: View) -> tuple[Image, Image]:
        """Mean and standard deviation (h, w) [m] of repeated frames behind this effect, from those in front of it.

        What is frozen shows in the mean and not in the spread.
        """
        behind = sigma if self.frozen else self.spread(sigma, mean, view)
        return mean + self.change(mean, view), behind

    def sampled(self, depth: Image, view: View, rng: np.random.Generator) -> Image:
        """The depth (h, w) [m] behind this effect in one frame: its change of the mean, and one draw with the standard
        deviation `noise`, normal and independent unless overridden.
        """
        change = self.change(depth, view)
        behind = depth + change if change.ndim or change else depth
        if self.frozen or not self.changes("noise"):
            return behind
        return behind + self.noise(depth, view) * normal(rng, depth)

    def window(self, view: View) -> float:
        """Side [px] of the square over which neighbours share this noise; 1 where pixels are independent."""
        return 1.0

    def summary(self, spread: float) -> dict[str, tuple[float, str]]:
        """What a person wants to know of long lists, as name: (value, unit); empty where the values say it themselves.

        Args:
            spread: standard deviation of one entry of a fitted list.
        """
        return {}

    def why_not_corrected(self) -> str:
        """Why `correct` leaves this effect; empty when it is undone."""
        return self.not_corrected if self.changes("bias") else ""

    @final
    @classmethod
    def changes(cls, channel: str) -> bool:
        """True when the effect has its own "bias", "noise", "dropout", "light" or "spread"."""
        return getattr(cls, channel) is not getattr(Effect, channel)


def _values(effect: Any) -> tuple[Any, ...]:
    return tuple(getattr(effect, entry.name) for entry in fields(effect))


def _same(a: Any, b: Any) -> bool:
    return np.array_equal(a, b) if isinstance(a, np.ndarray) or isinstance(b, np.ndarray) else bool(a == b)


def over_modulations(law: Callable[[View], Image], view: View) -> Image:
    """What a law of the modulation (of any shape) gives a range from all that a view has: their mean by frequency^2."""
    if not (view.frequencies and view.time_of_flight):
        return law(view)
    total = sum(f**2 for f in view.frequencies)
    return np.asarray(sum(f**2 / total * law(replace(view, modulation=f)) for f in view.frequencies))


def independent(sigma: Image, other: Image) -> Image:
    """Standard deviation of the sum of two independent errors; np.hypot takes five times as long."""
    return np.asarray(np.sqrt(sigma * sigma + other * other))


def normal(rng: np.random.Generator, like: Image) -> Image:
    """Independent standard normal numbers of the shape and type of an image."""
    return rng.standard_normal(like.shape, dtype=like.dtype.type)  # float32 or float64
