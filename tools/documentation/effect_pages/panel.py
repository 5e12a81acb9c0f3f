"""A panel of a picture: a law as a curve, or as a small image with a cut through it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.sensor.effect import Effect
from fusion.sensor.parameter import parameters
from fusion.sensor.view import Image, View
from tools.documentation.effect_pages.views import WIDTH

Numbers = NDArray[np.floating]
# label and factor from SI of what is drawn
LABELS = {
    "bias": ("change of the depth [mm]", 1000.0),
    "noise": ("noise [mm]", 1000.0),
    "dropout": ("missing [%]", 100.0),
    "light": ("amplitude [%]", 100.0),
}


@dataclass(frozen=True)
class Panel:
    """One pair of axes.

    Attributes:
        channel: "bias", "noise", "dropout" or "light"; tells the colour and the label.
        x, x_label: where the law is drawn.
        law: from an effect to its values (n,) at x, in SI; or the image (h, w) when `window` is given.
        note: what stands still, one line.
        label: of the vertical axis with the factor from SI; the channel's where empty.
        values: parameters that this panel draws at other values than the typical ones.
        window: rows and columns of the image that are shown, the middle one as a curve too; None for a curve only.
        outline: left, top, right and bottom of what stands in the image [px].
        steps: True where the curve jumps between points.
        log: True for a logarithmic axis of x.
        edge: True where x is the place across an edge at 0.
    """

    channel: str
    x: Numbers
    x_label: str
    law: Callable[[Effect], Numbers]
    note: str = ""
    label: tuple[str, float] | None = None
    values: dict[str, float] = field(default_factory=dict)
    window: tuple[slice, slice] | None = None
    outline: tuple[float, ...] = ()
    steps: bool = False
    log: bool = False
    edge: bool = False


@dataclass(frozen=True)
class Picture:
    """The panels of one effect, side by side.

    Attributes:
        halved: parameters that are halved for the second curve.
        given: parameters at their typical value; the others are neutral. All where None.
        make: makes the effect from a factor (1, or 0.5) instead.
    """

    panels: tuple[Panel, ...]
    halved: tuple[str, ...]
    given: tuple[str, ...] | None = None
    make: Callable[[float], Effect] | None = None

    def effect(self, kind: type[Effect], panel: Panel, factor: float) -> Effect:
        """The effect that a curve shows."""
        if self.make is not None:
            return self.make(factor)
        values: dict[str, Any] = {
            name: about.typical for name, about in parameters(kind).items() if self.given is None or name in self.given
        } | panel.values
        return kind(**{name: value * (factor if name in self.halved else 1.0) for name, value in values.items()})


def change(effect: Effect, view: View, channel: str) -> Image:
    """What an effect does to a view (h, w) in one channel; the light as a share of what arrives."""
    assert view.depth is not None
    if channel == "light":
        ir = np.ones(view.depth.shape) if view.ir is None else np.asarray(view.ir, float)
        return np.broadcast_to(effect.light(ir, view.depth, view) / ir, view.depth.shape)
    return np.broadcast_to(getattr(effect, channel)(view.depth, view), view.depth.shape)


def sweep(channel: str, x: Numbers, x_label: str, view: Callable[[float], View], note: str = "", **more: Any) -> Panel:
    """A curve: the view of one pixel for each value of x."""
    views: list[View] = []  # made when drawn

    def law(effect: Effect) -> Numbers:
        views.extend([] if views else (view(float(value)) for value in x))
        return np.array([change(effect, seen, channel)[0, 0] for seen in views])

    return Panel(channel, x, x_label, law, note, **more)


def across_edge(channel: str, view: Callable[[float], View], note: str = "", reach: float = 4.0) -> Panel:
    """A curve over the place across an edge [px], negative on the near side."""
    x = np.linspace(-reach, reach, 321)
    return sweep(channel, x, "place across the edge [px]", view, note, edge=True)


WHOLE = (slice(4, None, 8), slice(4, None, 8))  # every eighth pixel is enough for what is smooth


def image(
    channel: str, view: Callable[[], View], note: str = "", window: tuple[slice, slice] = WHOLE, **more: Any
) -> Panel:
    """A small image, and a cut along its middle row."""
    x = np.arange(WIDTH, dtype=float)[window[1]]
    return Panel(channel, x, "column [px]", lambda e: change(e, view(), channel)[window], note, window=window, **more)
