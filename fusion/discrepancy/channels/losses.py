"""Losses: missing values whose share no effect of the catalogue gives, with the names that lose values that way."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.unnamed import Unnamed, rising_gain, unnamed
from fusion.discrepancy.channels.validity import LEAST_LOST, Validity
from fusion.discrepancy.unknown.unrestricted import covariates
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.sensor import Sensor
from fusion.sensor.where import VARIABLES

Vector = NDArray[np.float64]

NAMED = 0.8  # of what smooth functions of everything known explain: less, and the name is not the right one
HIDDEN = "loses values that way, by a law that is a guess or asks for light that nobody recorded"
UNITS = {
    "depth": " m",
    "u": " px",
    "v": " px",
    "radius": " px",
    "incidence": " deg",
    "time": " s",
    "temperature": " degC",
}
LIMITED = ("depth", "range")  # in which the working range of a sensor ends
TRIED = np.linspace(0.0, 1.0, 18)[1:-1]  # of the pixels, then between two of them
SHARP = 1e-3  # of a limit, over which it is taken to set in: tables are straight between their nodes


@dataclass(frozen=True)
class Limit:
    """Nothing has a value beyond a number of one variable, or before it."""

    variable: str
    at: float  # [m]
    beyond: bool
    costs: Vector  # (recordings,) chi2 in each

    @property
    def step(self) -> ChannelStep:
        """What it says, as a law that has no name; `gain` and what follows of that are the caller's to fill in."""
        nodes = ((self.at * (1 - SHARP), self.at * (1 + SHARP)),)
        table = Tabulated((self.variable,), nodes, missing=np.array([0.0, 1.0] if self.beyond else [1.0, 0.0]))
        form = f"all {'beyond' if self.beyond else 'nearer than'} {self.at:.3g} m of {self.variable}"
        text = f"more values are missing than predicted, {form}: the working range ends, which no effect explains"
        return ChannelStep("dropout", None, {}, False, 0.0, 0.0, 1.0, variables=(self.variable,), text=text,
                           added=table, form=form)  # fmt: skip


def likeliest_limit(seen: Validity, costs: Callable[[Vector], Vector]) -> Limit:
    """The limit that explains missing values best.

    Args:
        costs: chi2 (recordings,) of a share (n,) of missing values.
    """
    found = [_limit(seen, costs, variable, beyond) for variable in LIMITED for beyond in (True, False)]
    return min(found, key=lambda one: float(one.costs.sum()))


def _limit(seen: Validity, costs: Callable[[Vector], Vector], variable: str, beyond: bool) -> Limit:
    """The best limit of one variable, on one side: looked for along its values, then between those beside the best."""
    images = [np.asarray(VARIABLES[variable](p.depth, p.view), float) for p in seen.patches]
    pixels = np.concatenate([x[p.tiles.label >= 0] for x, p in zip(images, seen.patches, strict=True)])
    found: dict[float, Vector] = {}
    low, high = float(np.nanmin(pixels)), float(np.nanmax(pixels))
    for _ in range(3):
        inside = pixels[(pixels >= low) & (pixels <= high)]
        for at in np.quantile(inside, TRIED).tolist():
            gone = [(x > at) == beyond for x in images]
            kept = [
                p.tiles.mean((1.0 - lost) * ~out)
                for p, lost, out in zip(seen.patches, seen.predicted, gone, strict=True)
            ]
            found[at] = costs(1.0 - np.concatenate(kept))
        each = sorted(found)
        best = min(each, key=lambda at: float(found[at].sum()))
        k = each.index(best)
        low, high = each[max(k - 1, 0)], each[min(k + 1, len(each) - 1)]
    return Limit(variable, best, beyond, found[best])


def loss_step(sensor: Sensor, seen: Validity) -> ChannelStep | None:
    """Missing values that depend on something known, as a table; None where there are none, or the model tells of them.

    Names are those of effects whose own law cannot be computed here (nobody recorded the light, or its form is a guess)
    and with whose cause the missing share rises: how it rises is no evidence for one of them or against it.
    """
    now = seen.share()
    excess, sigma = seen.missing - now, seen.sigma(np.maximum(now, seen.missing))
    law = unnamed(excess, sigma, seen.place, covariates(seen.observations))
    if law is None or float(np.quantile(law.fitted, 0.95)) < LEAST_LOST:
        return None
    gains = {kind: rising_gain(excess, sigma, values) for kind, values in _causes(seen)}
    names = sorted((k for k in gains if gains[k] > NAMED * law.gain), key=lambda kind: -gains[kind])
    if any(sensor.effect(kind.name) is not None for kind in names):
        return None  # the model holds what does this, and cannot tell how much
    table, form = _table(law), _said(law)
    text = f"more values are missing than predicted, depending on {', '.join(law.variables)}: {form}; "
    text += f"{names[0].name} {HIDDEN}" if names else "no effect explains it"
    return ChannelStep(
        "dropout",
        names[0]() if names else None,
        {},
        False,
        law.gain,
        min(law.gain / max(float(((excess / sigma) ** 2).sum()), 1e-9), 1.0),
        law.probability,
        tuple(kind.name for kind in names[1:]),
        variables=law.variables,
        text=text,
        added=table,
        form=form,
    )


def _causes(seen: Validity) -> Iterator[tuple[type[Effect], Vector]]:
    """Effects whose missing values rise with something in a way that is not known, and that of every tile (n,)."""
    for kind in EFFECTS:
        if kind.principles and seen.patches[0].sensor.principle not in kind.principles:
            continue
        parts = []
        for patch in seen.patches:
            with np.errstate(all="ignore"):
                cause = kind().loses_with(patch.depth, patch.block.view)
            if cause is None:
                break
            parts.append(patch.tiles.mean(cause))
        else:
            yield kind, np.concatenate(parts)


def _table(law: Unnamed) -> Tabulated:
    """The law over its variables; tiles know an amplitude by its logarithm."""
    grid = [np.exp(at) if name == "amplitude" else at for name, at in zip(law.variables, law.knots, strict=True)]
    share: Any = 0.0
    for axis, heights in enumerate(law.heights):
        share = share + heights.reshape([-1 if k == axis else 1 for k in range(len(grid))])
    nodes = tuple(tuple(float(x) for x in at) for at in grid)
    return Tabulated(law.variables, nodes, missing=np.clip(share, 0.0, 1.0))


def _said(law: Unnamed) -> str:
    """The form in words: the share at the ends and in the middle of the variable that tells most."""
    name, table = law.variables[0], _table(law)
    share = np.asarray(table.missing, float)
    share = share.mean(axis=tuple(range(1, share.ndim)))
    at = np.degrees(table.grid[0]) if name == "incidence" else np.asarray(table.grid[0])
    unit = UNITS.get(name, "")
    told = sorted({0, len(at) // 2, len(at) - 1})
    return ", ".join(f"{100 * share[k]:.0f} % at {at[k]:.3g}{unit}" for k in told) + f" of {name}"
