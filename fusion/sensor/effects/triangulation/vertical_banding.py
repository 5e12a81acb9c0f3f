"""Vertical banding: the chip corrects the pattern's drift in small jumps at some columns, seen as upright bands."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.camera import TRIANGULATING, Principle
from fusion.sensor.effect import Effect
from fusion.sensor.forms import Atom, Form
from fusion.sensor.laws.disparity import depth_change
from fusion.sensor.parameter import Value, parameter
from fusion.sensor.view import Image, View

SOURCE = "forums.structure.io/t/2330: thermal correction of the firmware; Chow and Lichti 2013"
BANDS = 8  # jumps across the image of a unit whose columns are not known: guess, after published plots of walls


@dataclass(frozen=True)
class VerticalBanding(Effect):
    """The disparity grows by the steps of all columns passed so far.

    Jumps of which only the usual size is known leave the image's mean as it is.
    """

    name: ClassVar[str] = "vertical_banding"
    key: ClassVar[str] = "N7"
    formula: ClassVar[str] = "d_measured = d + sum of steps_k where u > columns_k, d = fx b / z"
    variables: ClassVar[tuple[str, ...]] = ("u", "depth")
    principles: ClassVar[tuple[Principle, ...]] = TRIANGULATING
    frozen: ClassVar[str] = "unit"

    step: Value = parameter(
        "px",
        (0, 0.5),
        f"usual size of {BANDS} jumps up or down, at columns that this unit has and keeps",
        SOURCE,
        "typical",
        typical=0.06,
    )
    columns: Value = parameter(
        "px", (-1, 1e5), "where the known bands begin", SOURCE, "bands", typical=20.0, kind="list"
    )
    steps: Value = parameter(
        "px", (-1, 1), "change of the disparity at each column", SOURCE, "bands", typical=0.125, kind="list"
    )

    def bias(self, depth: Image, view: View) -> Image:
        columns, steps = np.broadcast_arrays(np.atleast_1d(self.columns), np.atleast_1d(self.steps))
        shift = _steps(columns, steps, view.u)
        if np.any(self.step) and view.moment.unit is not None:
            shift = shift + np.asarray(self.step) * _frozen_steps(depth.shape[1], view.moment.unit)
        return depth_change(depth, shift, view)

    def noise(self, depth: Image, view: View) -> Image:
        if not np.any(self.step):
            return np.zeros((), depth.dtype)
        # variance of one jump of +-1 at a random place, mean of the row taken off: (x^3 + (1 - x)^3) / 3
        x = (view.u + 0.5) / depth.shape[1]
        spread = np.sqrt(BANDS / 3 * (x**3 + (1 - x) ** 3))
        return np.abs(depth_change(depth, np.asarray(self.step) * spread, view))

    def summary(self, spread: float) -> dict[str, tuple[float, str]]:
        """Typical jump between bands: what stands at neighbouring columns is one jump, and noise is none."""
        columns, steps = np.broadcast_arrays(np.atleast_1d(self.columns), np.atleast_1d(self.steps))
        steps = steps[columns >= 0]
        jumps: list[float] = []
        last = -2
        for place in np.flatnonzero(np.abs(steps) > 4 * spread):
            if place == last + 1 and jumps and np.sign(jumps[-1]) == np.sign(steps[place]):
                jumps[-1] += float(steps[place])
            else:
                jumps.append(float(steps[place]))
            last = int(place)
        sizes = np.abs(jumps) if jumps else np.abs(steps)
        return {"step": (float(np.sqrt(np.mean(sizes**2))) if sizes.size else 0.0, "px")}

    @classmethod
    def own_forms(cls, shape: tuple[int, int]) -> list[Form]:
        """A level of the first band, then a step at every sixteenth column: any bands, as coarse as that."""
        atoms = tuple({"columns": [float(c)], "steps": [0.002]} for c in (-1, *range(16, shape[1], 16)))
        return [Form(cls, atoms=atoms, join=_joined)]


def _joined(atoms: Sequence[Atom], weights: Sequence[float]) -> Atom:
    columns, steps = (np.array([atom[name] for atom in atoms], float)[:, 0] for name in ("columns", "steps"))
    return {"columns": columns, "steps": np.asarray(weights, float) * steps}


def _steps(columns: NDArray[np.floating], steps: NDArray[np.floating], u: NDArray[np.floating]) -> NDArray[np.floating]:
    """(1, w) sum of the steps at columns to the left of u."""
    return np.sum(steps[:, None] * (u > columns[:, None]), axis=0, keepdims=True)


@lru_cache(maxsize=16)
def _frozen_steps(width: int, unit: int) -> NDArray[np.float64]:
    """(1, w) BANDS jumps of +-1 at random columns, with mean 0; read only."""
    rng = np.random.default_rng([unit, *b"vertical_banding"])
    columns, signs = rng.uniform(-0.5, width - 0.5, BANDS), np.sign(rng.uniform(-1, 1, BANDS))
    bands = _steps(columns, signs, np.arange(float(width))[None, :])
    bands = bands - bands.mean()
    bands.flags.writeable = False
    return bands
