"""Makes a case: recordings and sensor model in a folder; all else stays with the one who made it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.injected import injected_plan
from tools.trial.concealed.known import known_part
from tools.trial.concealed.labels import label_of
from tools.trial.concealed.oracle import Oracle, oracle_of
from tools.trial.concealed.plan import Plan, plan
from tools.trial.concealed.shot import Shot
from tools.trial.concealed.writing import sensor_file, write_recording

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Made:
    """A case with all that its maker knows.

    Attributes:
        depth: (h, w) [m] mean of the frames of each moment of the oracle, NaN where any is missing.
        oracle: of the recordings in the case; None where the mean depth is not changed.
    """

    plan: Plan
    label: dict[str, Any]
    depth: list[Array]
    oracle: Oracle | None


def make(family: str, seed: list[int], folder: Path, shared: Path | None = None) -> Made | None:
    """Write a case to `folder` (recordings, sensor.json); None where real recordings are needed and absent.

    Args:
        shared: folder with `data/`, for cases that conceal something in real recordings.
    """
    rng = np.random.default_rng(seed)
    case = injected_plan(rng, shared) if family == "injected" else plan(family, rng)
    return None if case is None else written(case, seed, folder, rng)


def written(case: Plan, seed: list[int], folder: Path, rng: np.random.Generator) -> Made:
    """The recordings and sensor.json of a plan, written to `folder`."""
    folder.mkdir(parents=True)
    depth = write_recordings(case, case.shots, folder, rng)
    (folder / "sensor.json").write_text(sensor_file(known_part(case), case.flight))
    oracle = oracle_for(case, case.unmoved) if any(law.channel == "bias" for law in case.missing) else None
    return Made(case, label_of(case, oracle, seed), depth, oracle)


def oracle_for(case: Plan, shots: Sequence[Shot]) -> Oracle:
    known = np.array([[case.stated["std"], 0.0]]) if case.stated else np.zeros((0, 2))
    return oracle_of(case.device, shots, known, case.mesh_sigma_m)


def write_recordings(
    case: Plan, shots: Sequence[Shot], folder: Path, rng: np.random.Generator, first: int = 0, logged: bool = False
) -> list[Array]:
    """Shots as recordings numbered from `first`; the mean depth of each moment, as `oracle_of` takes them.

    Args:
        logged: with temperatures, whatever the others of the case have.
    """
    laws = [*case.known, *case.missing]
    about = {"scale": 1000 if case.flight else 5000, "mesh_sigma_m": case.mesh_sigma_m}
    about["temperature"] = logged or (case.setting.kind in ("warm", "trend") and case.metadata != "log")
    about["grey"] = case.metadata == "reflectance"
    groups: dict[int, list[Shot]] = {}
    for i, shot in enumerate(shots):
        groups.setdefault(-1 - i if shot.series is None else shot.series, []).append(shot)
    out: list[Array] = []
    for number, group in enumerate(groups.values(), first):
        taken: list[tuple[Array, Array | None]] = [case.device.record(shot, laws, rng) for shot in group]
        write_recording(folder / f"rec_{number:02d}", group, taken, about)
        for shot, (depth, _) in zip(group, taken, strict=True):
            step = 2 if shot.long else len(depth)
            parts = (depth[i : i + step] for i in range(0, len(depth), step))
            out += [np.where((part > 0).all(axis=0), part.mean(axis=0), np.nan) for part in parts]
    return out
