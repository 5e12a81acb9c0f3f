"""Law: something in the light, the electronics or the matching that the given sensor model does not hold."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.shot import Place

Array = NDArray[np.float64]
Acts = Callable[[Place], Array]


@dataclass(frozen=True)
class Law:
    """Attributes:
    name: the effect that a catalogue would name, or "unknown".
    stage: "delay" [m of range], "light" (more phasor per modulation), "harmonic" (of the correlation),
        "disparity" [px], "noise" (factor), "filter" (memory), "dark" and "bright" (thresholds in counts),
        "loss" (probability), "rig" (moves what is seen: the table's own errors, not this law, say how).
    acts: of a place, at unit size. For "light": (place, phasors (f, h, w), modulations) -> what is added.
    size: times which it acts.
    mask: share (h, w) with which it acts at a place, everywhere without.
    parameter: name and value at unit size, where a catalogue's parameter means the same.
    """

    name: str
    stage: str
    acts: Callable[..., Any]
    variables: tuple[str, ...]
    size: float = 1.0
    mask: Acts | None = None
    region: tuple[dict[str, Any], ...] = ()
    accept: tuple[str, ...] = ()
    shifted: bool = False
    parameter: tuple[str, float] | None = None

    @property
    def channel(self) -> str:
        return {"noise": "noise", "filter": "noise", **dict.fromkeys(("dark", "bright", "loss"), "dropout")}.get(
            self.stage, "bias"
        )

    def share(self, place: Place) -> Array:
        """(h, w) with which it acts, times its size."""
        return self.size * (np.ones(place.z.shape) if self.mask is None else self.mask(place))


def noisier(laws: Sequence[Law], place: Place) -> Array:
    """Factor (h, w) on the noise of a frame."""
    out = np.ones(place.z.shape)
    for law in laws:
        if law.stage == "noise":
            factor = law.size * np.nan_to_num(law.acts(place), nan=1.0)
            out = out * (factor if law.mask is None else 1 + (factor - 1) * law.mask(place))
    return out


def memory_of(laws: Sequence[Law]) -> float:
    """Share of the value before in the value given out."""
    return float(sum(law.size * law.acts(None) for law in laws if law.stage == "filter"))


def lottery(laws: Sequence[Law], place: Place, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Pixels (h, w) that are lost in this frame."""
    out = np.zeros(place.z.shape, bool)
    for law in laws:
        if law.stage == "loss":
            out |= rng.random(place.z.shape) < law.share(place) * np.nan_to_num(law.acts(place))
    return out
