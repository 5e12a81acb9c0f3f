"""Views and single corners that do not fit the others: named, with the reason."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fusion.calibration.lens.boards.grid import plane_misfit
from fusion.calibration.lens.fit.solve import LensSolution, placed, residual, solve
from fusion.calibration.lens.fit.spread import spread
from fusion.calibration.lens.views import BoardView
from fusion.errors import RecordingError
from fusion.geometry.pose import Array
from fusion.geometry.robust import robust_std

ROUNDS = 10
FACTOR = 2.5  # times the usual error of a view: far and near, sharp and blurred views differ by less (measured: 1.9)
LEAST_PX = 0.2  # below, a view is at worst a bent board, not a wrong one
SPREADS = 4.5  # robust standard deviations of the logarithm
GROSS = 10.0  # times the usual misfit of a plane: no lens does that to one view alone
WILD = 6.0  # robust standard deviations of a single corner: glare, a finger
LEAST_WILD_PX = 0.15
MOST_WILD = 0.15  # of a view's corners; above, the view itself is wrong
MOST_VIEWS = 0.4  # of all: beyond, nobody can say which side is wrong
SWAYS, SWAYING = 1.0, 2.0  # Cook's distance, and times the usual error, that together make a view an outlier


@dataclass(frozen=True)
class Outlier:
    """A view that was left out: its name, its error [px] under the camera of the others, and why."""

    name: str
    rms_px: float
    reason: str


@dataclass(frozen=True)
class JudgedViews:
    """What is left after judging."""

    views: list[BoardView]  # those that fit, without wild corners
    outliers: list[Outlier]  # those that do not
    solution: LensSolution  # the camera from `views`
    wild: dict[str, int]  # view name to number of single corners left out


def judge(views: Sequence[BoardView], size: tuple[int, int], keep: bool = False, rational: bool = False) -> JudgedViews:
    """Solve, leave out what does not fit, and solve again until nothing changes; `keep` names but does not leave out.

    Args:
        keep: use outliers all the same.
        rational: the lens has the twelve parameters of OpenCV's rational form.

    Raises:
        RecordingError: too few views, or so many disagree that it cannot be said which are wrong.
    """
    views = list(views)
    bad = _not_plane(views)
    solution, rms = _solved(views, bad, size, rational)
    for _ in range(ROUNDS):
        found = _standing_out(rms, views, bad, solution)
        if len(found) > MOST_VIEWS * len(views):
            do = "look at the pictures: board.json, another board in view, a moving or bent board"
            raise RecordingError("the views contradict each other", found=f"{len(found)} of {len(views)}", do=do)
        if found == bad:
            break
        bad = found
        solution, rms = _solved(views, bad, size, rational)
    outliers = [Outlier(views[i].name, float(rms[i]), reason) for i, reason in sorted(bad.items())]
    if keep:
        return JudgedViews(views, outliers, solve(views, size, rational=rational), {})
    kept, wild = _without_wild([v for i, v in enumerate(views) if i not in bad], solution)
    return JudgedViews(kept, outliers, solve(kept, size, solution.parameters) if wild else solution, wild)


def _not_plane(views: list[BoardView]) -> dict[int, str]:
    """Views whose corners lie on no plane, while those of the others do."""
    if not views:  # told when they are solved
        return {}
    misfit = np.array([plane_misfit(view.points[:, :2], view.pixels)[0] for view in views])
    usual = float(np.median(misfit))
    bad = np.flatnonzero(~(misfit <= np.maximum(GROSS * usual, 1.0)))
    return {int(i): f"no plane board: {misfit[i]:.1f} px, the others {usual:.2f} px" for i in bad}


def _solved(
    views: list[BoardView], bad: dict[int, str], size: tuple[int, int], rational: bool
) -> tuple[LensSolution, Array]:
    """The camera of the good views, and the error [px] of every view under it."""
    solution = solve([view for i, view in enumerate(views) if i not in bad], size, rational=rational)
    rms = np.zeros(len(views))
    rms[[i for i in range(len(views)) if i not in bad]] = [_usual_error(r) for r in solution.residuals]
    for i in bad:
        pose = placed(views[i], solution.parameters)
        rms[i] = np.inf if pose is None else _usual_error(residual(views[i], pose, solution.parameters))
    return solution, rms


def _usual_error(residuals: Array) -> float:
    """Root mean square distance [px] of the corners (n, 2) without the worst few: those are judged one by one."""
    squares = np.sort((residuals**2).sum(axis=1))
    return float(np.sqrt(squares[: int(np.ceil((1 - MOST_WILD) * len(squares)))].mean()))


def _standing_out(rms: Array, views: list[BoardView], bad: dict[int, str], solution: LensSolution) -> dict[int, str]:
    good = [i for i in range(len(views)) if i not in bad]
    usual = float(np.median(rms[good]))
    scatter = robust_std(np.log(np.maximum(rms[good], 1e-9) / max(usual, 1e-9)))
    limit = max(LEAST_PX, usual * max(FACTOR, float(np.exp(min(SPREADS * scatter, 3)))))
    found = {int(i): f"{rms[i]:.2f} px, the others {usual:.2f} px" for i in np.flatnonzero(rms > limit)}
    if len(good) > 5:
        influence = spread([views[i] for i in good], solution).influence
        for i, sway in zip(good, influence, strict=True):
            if i not in found and sway > SWAYS and rms[i] > max(LEAST_PX, SWAYING * usual):
                found[i] = f"{rms[i]:.2f} px, the others {usual:.2f} px, and it sways the camera more than its scatter"
    # a view that was swayed out comes back only when it is no more than ordinary
    return found | {
        i: reason for i, reason in bad.items() if i not in found and rms[i] > max(LEAST_PX, SWAYING * usual)
    }


def _without_wild(views: list[BoardView], solution: LensSolution) -> tuple[list[BoardView], dict[str, int]]:
    """The views without single corners far beyond the others."""
    length = [np.linalg.norm(r, axis=1) for r in solution.residuals]
    usual = float(np.median(np.concatenate(length)))
    kept, wild = [], {}
    for view, distances in zip(views, length, strict=True):
        # Rayleigh: the median is 1.18 standard deviations of a coordinate; a blurred view has more
        far = distances > max(WILD * max(usual, float(np.median(distances))) / 1.18, LEAST_WILD_PX)
        if far.any() and far.mean() <= MOST_WILD and (~far).sum() >= 6:
            wild[view.name] = int(far.sum())
            view = view.only(~far)
        kept.append(view)
    return kept, wild
