"""The lateral law: how much a target's edges jitter, beside a shadow and not."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.laws.fit import Data, NoiseFit, choose, fit_law
from fusion.calibration.noise.poses import Pose
from fusion.sensor.effects.readout.lateral_noise import LateralNoise

FEWEST = 3  # edges
PERCENTILE = 90.0  # of all poses: what Fankhauser proposes as a careful value

Array = NDArray[np.floating]


@dataclass(frozen=True)
class TargetEdges:
    """Edges of targets, all (n,)."""

    depth: Array  # of the edge [m]
    tilt: Array  # of the target [rad]
    # sigma, sigma_std: jitter [m], and how well it is known
    sigma: Array
    sigma_std: Array
    shadowed: NDArray[np.bool_]  # whether it lies beside a shadow
    side: NDArray[np.intp]  # 0 left, 1 right

    def part(self, which: NDArray[np.bool_]) -> "TargetEdges":
        """Some of them."""
        return TargetEdges(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


@dataclass(frozen=True)
class LateralForm:
    """A constant in metres ("sigma"), in pixels ("sigma_px"), or in pixels and growing with the tilt ("growth_px")."""

    title: str
    names: tuple[str, ...]
    edges: TargetEdges
    fx: float

    def part(self, which: NDArray[np.bool_]) -> "LateralForm":
        """The same at some of the edges."""
        return replace(self, edges=self.edges.part(which))

    def bounds(self) -> tuple[Array, Array]:
        """All are spreads; a growth of 0 is none."""
        return np.zeros(len(self.names)), np.full(len(self.names), 100.0)

    def start(self, values: Array) -> Array:
        """Medians."""
        sigma = np.sqrt(np.maximum(values, 0))
        usual = {"sigma": np.median(sigma), "sigma_px": np.median(sigma / self.edges.depth) * self.fx}
        return np.array([float(usual.get(name, 0.01)) for name in self.names])

    def predict(self, numbers: Array) -> Array:
        """(n,) variances [m^2]: they, not their roots, are measured without bias where a jitter is below a pixel."""
        p = dict(zip(self.names, numbers, strict=True))
        grows = self.edges.tilt / (np.pi / 2 - np.minimum(self.edges.tilt, np.deg2rad(85)))
        pixels = p.get("sigma_px", 0.0) + p.get("growth_px", 0.0) * grows
        return np.asarray((p.get("sigma", 0.0) + pixels * self.edges.depth / self.fx) ** 2)


FORMS = {
    "constant in metres (Fankhauser)": ("sigma",),
    "constant in pixels": ("sigma_px",),
    "in pixels, growing with the tilt (Nguyen)": ("sigma_px", "growth_px"),
}


@dataclass(frozen=True)
class LateralLaw:
    """Lateral noise."""

    edges: TargetEdges  # all that were measured
    fits: list[NoiseFit]  # every form that competed, on edges without a shadow where there are such; `chosen` is in use
    chosen: int
    shadow: NoiseFit | None  # the constant fitted to edges beside a shadow, or None
    # percentile, percentile_shadow: 90th percentile [m] over edges without and beside a shadow, NaN without such
    percentile: float
    percentile_shadow: float

    @property
    def best(self) -> NoiseFit:
        """The form in use."""
        return self.fits[self.chosen]

    @property
    def held(self) -> NoiseFit:
        """The fit that the effect can hold: it knows no growth with the tilt."""
        return self.best if len(self.best.numbers) == 1 else self.fits[1]

    @property
    def effect(self) -> LateralNoise:
        """As the sensor model holds it."""
        values: dict[str, Any] = dict(zip(self.held.form.names, map(float, self.held.numbers), strict=True))
        return LateralNoise(**values)

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of the effect's number."""
        return dict(zip(self.held.form.names, map(float, self.held.std), strict=True))


def edges_of(poses: list[Pose]) -> TargetEdges:
    """The edges whose jitter was measured."""
    rows = [
        (
            pose.seen.edge_depth[side],
            pose.tilt,
            pose.seen.lateral[side],
            pose.seen.lateral_std[side],
            pose.shadowed[side],
            side,
        )
        for pose in poses
        for side in (0, 1)
        if np.isfinite(pose.seen.lateral[side]) and pose.seen.lateral_std[side] > 0
    ]
    depth, tilt, sigma, deviation, shadowed, sides = np.array(rows, float).reshape(-1, 6).T
    return TargetEdges(depth, tilt, sigma, deviation, shadowed.astype(bool), sides.astype(np.intp))


def lateral_law(poses: list[Pose], fx: float) -> LateralLaw | None:
    """Fit the forms and choose by held-out edges; None when there are fewer than three edges."""
    edges = edges_of(poses)
    use = ~edges.shadowed if (~edges.shadowed).sum() >= FEWEST else np.ones(len(edges.depth), bool)
    if use.sum() < FEWEST:
        return None
    open_ones, dark = edges.part(use), edges.part(edges.shadowed)
    fits = [fit_law(LateralForm(title, names, open_ones, fx), _variances(open_ones)) for title, names in FORMS.items()]
    chosen = choose(fits)
    names = fits[chosen].form.names[:1]
    shadow = None
    if len(dark.depth) >= FEWEST:
        shadow = fit_law(LateralForm("beside a shadow", names, dark, fx), _variances(dark))
    return LateralLaw(edges, fits, chosen, shadow, *(_percentile(e.sigma) for e in (edges.part(~edges.shadowed), dark)))


def _variances(edges: TargetEdges) -> Data:
    """Measured variances [m^2]; where a jitter is below the pixel grid's own, half its deviation is the variance's."""
    error = 2 * edges.sigma_std * np.maximum(edges.sigma, 2 * edges.sigma_std)
    return Data(edges.sigma**2, error, relative=False)


def _percentile(sigma: Array) -> float:
    return float(np.percentile(sigma, PERCENTILE)) if len(sigma) else float("nan")
