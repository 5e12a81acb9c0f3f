"""A case: recordings and what is known of their sensor; and the same once it is spoiled."""

import json
import shutil
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tools.trial.spoiled.folder import Taken, read, write

Rng = np.random.Generator


@dataclass(frozen=True)
class Case:
    """`sensor` is the content of sensor.json, or the name of a preset."""

    recordings: tuple[Taken, ...]
    sensor: dict[str, Any] | str


@dataclass(frozen=True)
class Told:
    """What tells the spoil beside a claim.

    Attributes:
        words: pattern that the headline holds.
        pose_factor: size of `nuisances.pose_factor`, right within a factor of two.
        shape_rms_m: size of `nuisances.shape_rms_m`, right within a factor of two.
        outliers: recordings that `outliers` has to name, all of them and no others.
        repeats: pairs of recordings that `repeats` has to join.
        refused: pattern of a refusal that counts as told.
    """

    words: str
    pose_factor: float | None = None
    shape_rms_m: float | None = None
    outliers: tuple[str, ...] = ()
    repeats: tuple[tuple[str, str], ...] = ()
    refused: str = ""


@dataclass(frozen=True)
class Spoiled:
    """A case after one spoil.

    Attributes:
        text: how strong, and where.
        names: effects of the catalogue that are true now because of it.
    """

    case: Case
    text: str
    told: Told
    names: tuple[str, ...] = field(default=())


def opened(folder: Path, most: int, sensor: str | None = None) -> Case:
    """The first `most` recordings of a folder, and its sensor.json unless a preset is named."""
    paths = sorted(folder.glob("rec_*"))[:most]
    known = sensor or json.loads((folder / "sensor.json").read_text(encoding="utf-8"))
    return Case(tuple(read(path) for path in paths), known)


def put(case: Case, folder: Path) -> tuple[list[Path], str]:
    """Folders of the recordings, and what `--sensor` takes."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    paths = [folder / taken.name for taken in case.recordings]
    for taken, path in zip(case.recordings, paths, strict=True):
        write(taken, path)
    if isinstance(case.sensor, str):
        return paths, case.sensor
    file = folder / "sensor.json"
    file.write_text(json.dumps(case.sensor, indent=1), encoding="utf-8")
    return paths, str(file)


def some(case: Case, rng: Rng, most: int) -> list[int]:
    """Numbers of 1 to `most` recordings, but never more than a third of them."""
    count = int(rng.integers(1, max(min(most, len(case.recordings) // 3), 1) + 1))
    return sorted(int(i) for i in rng.choice(len(case.recordings), count, replace=False))


def with_recordings(case: Case, changed: dict[int, Taken]) -> Case:
    """The case with these in the place of others."""
    return replace(case, recordings=tuple(changed.get(i, taken) for i, taken in enumerate(case.recordings)))
