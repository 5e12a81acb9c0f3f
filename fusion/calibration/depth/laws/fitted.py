"""The chosen law, fitted to the end: periods of waves, the laser's true scatter, and the law's own curvature."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import chdtrc

from fusion.calibration.depth.laws.information import Information, WallEvidence, evidence_of, information_of
from fusion.calibration.depth.laws.law_sensor import LawNumbers, with_law
from fusion.calibration.depth.laws.selection import FittedLaw, Problem
from fusion.calibration.depth.laws.terms import LawTerm, length, wave_terms
from fusion.calibration.depth.walls.samples import WallSamples
from fusion.calibration.depth.walls.wall import Wall
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

ROUNDS = 5  # a law without waves is nearly linear: its second round changes a hundredth of the first
LONGEST = 0.01  # share by which a period moves in a round: half a step of the grid it was found on
UNLIKELY = 0.05
MOST = 1.0  # [m] a scatter that no wall has: where the root is looked for
Array = NDArray[np.floating]


@dataclass(frozen=True)
class Fitted:
    """A law with its final numbers."""

    # of the law (n,), first those of the curve's own numbers, last the derivatives to the periods
    terms: tuple[LawTerm, ...]
    numbers: LawNumbers  # by name, as effects want them
    covariance: NDArray[np.floating]  # (n, n) of the terms' numbers
    scatter: float  # standard deviation [m] of the walls' distances beyond the stated one; 0 when that explains them
    sensor: Sensor  # with the law's effects
    evidence: list[WallEvidence]  # per wall, `rest` being what the law leaves over [m]


@dataclass(frozen=True)
class FitSetting:
    """What the final fit needs beside the law: camera, known sensor, and what `LawNumbers` holds that is not fitted."""

    camera: Camera
    known: Sensor
    nodes: tuple[float, ...]
    ir_reference: float
    ratio: NDArray[np.floating] | None
    ir_span: tuple[float, float] = (100.0, 65535.0)


def finish(problem: Problem, law: FittedLaw, terms: list[LawTerm], setting: FitSetting) -> Fitted:
    """Fit a law to all walls, with its periods and at its own values."""
    by_key = {term.key: term for term in terms}
    chosen = [by_key[key] for key in law.keys]
    value = dict(zip(law.keys, map(float, law.numbers), strict=True))
    walls = [e.wall for e in problem.evidence]
    variances = [e.variance for e in problem.evidence]
    for _ in range(ROUNDS):
        every, _, total = _system(walls, variances, chosen, value, law.held, setting)
        value = _stepped(value, every, _step(total, every, value))
    every, left, total = _system(walls, variances, chosen, value, law.held, setting)
    scatter = excess(left, [e.rest for e in left], len(value) - sum(t.shape for t in chosen))
    covariance = _covariance(total, left, scatter) if every else np.zeros((0, 0))
    std = {term.key: float(s) for term, s in zip(every, np.sqrt(np.diag(covariance)), strict=True)}
    if "gloss" in std:
        std["gloss"] = max(std["gloss"], _without_each(left, every, "gloss"))
    std |= {f"period {key[4:]}": 0.0 for key in value if law.held and key.startswith("sin ")}
    numbers = _numbers(value, std, setting)
    sensor = with_law(setting.known, setting.camera, numbers)
    left = [replace(e, distance_std=float(np.hypot(e.distance_std, scatter))) for e in left]
    return Fitted(tuple(every), numbers, covariance, scatter, sensor, left)


def _covariance(total: Information, evidence: list[WallEvidence], scatter: float) -> NDArray[np.floating]:
    """(n, n) of numbers fitted as the walls' stated deviations weigh them, as candidates are judged: scatter widens it.

    Weighing by the scatter too would leave the law to single tiles within a wall, and err more on walls left out.
    """
    covariance = total.covariance(list(range(len(total.b))))
    pulls = [e.terms.T @ e.projected(e.nuisances[:, 2]) for e in evidence if np.isfinite(e.distance_std)]
    return covariance + sum((scatter**2 * np.outer(p, p) for p in (covariance @ q for q in pulls)), 0 * covariance)


def _without_each(evidence: list[WallEvidence], terms: list[LawTerm], key: str) -> float:
    """Standard deviation of a number by leaving out every wall once: a few boards may decide what is mirrored."""
    parts = [information_of(e, terms) for e in evidence]
    which, every = [term.key for term in terms].index(key), list(range(len(terms)))
    others = [parts[:i] + parts[i + 1 :] for i in range(len(parts))]
    moved = np.array([sum(some[1:], some[0]).fit(every)[which] for some in others])
    return float(np.sqrt((len(moved) - 1) * np.mean((moved - moved.mean()) ** 2)))


def _system(
    walls: list[Wall],
    variances: list[NDArray],
    chosen: list[LawTerm],
    value: dict[str, float],
    held: bool,
    setting: FitSetting,
) -> tuple[list[LawTerm], list[WallEvidence], Information]:
    """Terms at the present numbers, what these leave over on every wall, and the sums of that.

    `held`: periods stay as they are.
    """
    every = chosen if held else _with_periods(chosen, value)
    sensor = with_law(setting.known, setting.camera, _numbers(value, {}, setting))
    evidence = [_at(w, every, sensor, setting, v) for w, v in zip(walls, variances, strict=True)]
    if "gloss" in value:  # the board's, which the sensor does not hold
        column = [term.key for term in every].index("gloss")
        evidence = [replace(e, rest=e.rest - value["gloss"] * e.terms[:, column]) for e in evidence]
    parts = [information_of(e, every) for e in evidence]
    return every, evidence, sum(parts[1:], parts[0])


def _numbers(value: dict[str, float], std: dict[str, float], setting: FitSetting) -> LawNumbers:
    std = {key: std.get(key, 0.0) for key in value} | {k: s for k, s in std.items() if k.startswith("period")}
    return LawNumbers(value, std, setting.nodes, setting.ir_reference, setting.ratio, setting.ir_span)


def _at(wall: Wall, terms: list[LawTerm], sensor: Sensor, setting: FitSetting, variance: NDArray) -> WallEvidence:
    """The wall's evidence with `rest` = measured less what the whole sensor model predicts."""
    evidence = evidence_of(wall, setting.camera, setting.known, terms)
    depth = wall.true_plane.depth(setting.camera)
    predicted = sensor.predict(depth, wall.view(setting.camera, depth))
    rest = evidence.tiles.mean(np.nan_to_num(np.where(wall.mask, wall.measured - predicted, 0.0)))
    return replace(evidence, rest=rest, variance=variance)


def _with_periods(chosen: list[LawTerm], value: dict[str, float]) -> list[LawTerm]:
    """The terms at the present periods, and those of the periods themselves."""
    sines = [key for key in value if key.startswith("sin ")]
    others = [term for term in chosen if term.effect != "cyclic_error"]
    derivatives = [_period_term(key[4:], value[key], value["cos " + key[4:]]) for key in sines]
    return others + wave_terms(tuple(float(key[4:]) for key in sines)) + derivatives


def _period_term(name: str, s: float, c: float) -> LawTerm:
    """Change of the length per metre of period."""
    period = float(name)

    def law(at: WallSamples) -> NDArray:
        r = at.depth * at.stretch
        k = 2 * np.pi / period
        return -(k / period) * r * (s * np.cos(k * r) - c * np.sin(k * r))

    return LawTerm(f"period {name}", "cyclic_error", "period", "m", length(law), 0.05, highest=LONGEST * period)


def _step(total: Information, terms: list[LawTerm], value: dict[str, float]) -> NDArray[np.floating]:
    """(n,) change of the numbers; the prior draws the numbers themselves to 0, not their changes."""
    if not terms:
        return np.zeros(0)
    now = np.array([value.get(term.key, 0.0) for term in terms])
    drawn = replace(total, b=total.b - total.prior * now)
    return drawn.fit(list(range(len(terms))))


def _stepped(value: dict[str, float], terms: list[LawTerm], step: NDArray) -> dict[str, float]:
    """The numbers after a step; a wave whose period moves gets another name."""
    new = dict(value)
    moved = {}
    for term, change in zip(terms, step, strict=True):
        if term.key.startswith("period"):
            old = float(term.key[7:])
            # a period runs away where the wave is not seen
            moved[term.key[7:]] = old * float(np.clip(1 + change / old, 1 - LONGEST, 1 + LONGEST))
        else:
            new[term.key] = new.get(term.key, 0.0) + float(change)
    for old_name, period in moved.items():
        for wave in ("sin ", "cos "):
            new[f"{wave}{period:.6f}"] = new.pop(wave + old_name)
    return new


def excess(evidence: list[WallEvidence], rests: list[Array], numbers: int) -> float:
    """Standard deviation [m] that every wall's distance has beyond the stated one; 0 when there may be none.

    It is added to the stated ones in squares: what spoils distances (a board of another size or bent, a phase that is
    off) knows nothing of how well a laser or a camera could have told them.

    Args:
        evidence: of the walls, with the deviations as stated.
        rests: per wall (t,) [m] what a law leaves over.
        numbers: how many numbers of the law the distances alone can tell.
    """
    off, variance = [], []
    for e, rest in zip(evidence, rests, strict=True):
        if np.isfinite(e.distance_std):
            w = 1 / np.sqrt(e.variance)
            G = e.nuisances * w[:, None]
            off.append(float(np.linalg.lstsq(G, rest * w, rcond=None)[0][2]))
            variance.append(e.wall.distance_std**2 + float(np.linalg.inv(G.T @ G)[2, 2]))
    freedom = len(off) - numbers
    squares, known = np.square(off), np.array(variance)
    if freedom < 2 or chdtrc(freedom, float((squares / known).sum())) > UNLIKELY:
        return 0.0
    return float(brentq(lambda s: float((squares / (known + s * s)).sum()) - freedom, 0.0, MOST))
