"""Spoils of what is counted twice: still scenes recorded twice, a copy under another name."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tools.trial.spoiled.case import Case, Rng, Spoiled, Told, some
from tools.trial.spoiled.folder import Array, Taken

GAP = 5.0  # [s] between the two recordings of a scene: what starting one anew takes


def scenes_twice(case: Case, rng: Rng) -> Spoiled:
    """Odd and even frames as two folders: noise of their own, the same frozen pattern. Long series stay whole."""
    out: list[Taken] = []
    pairs = []
    for taken in case.recordings:
        span = taken.times[-1] - taken.times[0]
        if len(taken.times) < 4 or span > GAP:
            out.append(taken)
            continue
        first, second = _split(taken, 0, 0.0), _split(taken, 1, GAP + span)
        pairs.append((first.name, second.name))
        out += [first, second]
    case = replace(case, recordings=tuple(out))
    told = Told("repeat|twice|same place|same scene", repeats=tuple(pairs))
    return Spoiled(case, f"{len(pairs)} scenes twice", told)


def copied(case: Case, rng: Rng) -> Spoiled:
    """1 to 3 recordings once more, every count the same, by another name and 100 to 1000 s later."""
    out, pairs = list(case.recordings), []
    for i in some(case, rng, 3):
        taken = case.recordings[i]
        name = f"rec_{50 + i}"
        later = float(np.round(rng.uniform(100, 1000), 3))
        out.append(
            replace(retimed(taken, np.arange(len(taken.times)), later), name=name, infrared=_later(taken, later))
        )
        pairs.append((taken.name, name))
    told = Told("cop(y|ies)|twice|same", repeats=tuple(pairs), refused="cop(y|ies)|twice|same")
    return Spoiled(replace(case, recordings=tuple(out)), ", ".join(a for a, _ in pairs), told)


def retimed(taken: Taken, frames: NDArray[np.intp], later: float) -> Taken:
    """These frames alone, with their poses and log, `later` [s]; infrared images stay."""
    times = taken.times[frames]
    poses = np.array([taken.poses[np.argmin(np.abs(taken.poses[:, 0] - t))] for t in times])
    poses[:, 0] = times + later
    log = taken.log[:1]
    for t in times if taken.log else ():
        row = min(taken.log[1:], key=lambda line: abs(float(line.split(",")[0]) - t)).split(",")
        log.append(",".join([f"{t + later:.6f}", *row[1:]]))
    return replace(taken, times=times + later, depth=taken.depth[frames], poses=poses, log=log)


def _split(taken: Taken, part: int, later: float) -> Taken:
    frames = np.arange(part, len(taken.times), 2)
    half = retimed(taken, frames, later)
    # an image of the first frame serves both: it is the same scene in the same light
    infrared = [(float(half.times[0]), image) for _, image in taken.infrared[:1]]
    return replace(half, name=f"{taken.name}_{'ab'[part]}", infrared=infrared)


def _later(taken: Taken, later: float) -> list[tuple[float, Array]]:
    return [(t + later, image) for t, image in taken.infrared]
