"""What is spoiled: open challenges and cases of the trial's generator, and the presets' own simulations."""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tools.sets.judging.command import fusion
from tools.trial.concealed.making import make
from tools.trial.spoiled.case import Case, opened
from tools.trial.spoiled.folder import Taken
from tools.trial.spoiled.replicas import retimed
from tools.trial.spoiled.surfaces import views

CHALLENGES = Path(__file__).resolve().parents[4] / "shared" / "challenges"
OPEN_NULLS, OPEN_PLANTED = ("dev_00", "dev_01"), ("dev_02", "dev_03", "dev_04", "dev_05", "dev_06", "dev_09")
PRESETS = ("kinect-v1", "kinect-v2-indoors", "realsense-d435", "azure-kinect")
MOST = 8  # recordings of a case: a run has to end within some 40 s
KINDS = ("null", "planted", "preset")


@dataclass(frozen=True)
class Base:
    """Attributes:
    missing: effects that are missing, as the labels of challenges and trial tell them; empty for nothing.
    free: known effects whose stated value is off: correcting them is no claim.
    alike: names that are truly alike in these data.
    """

    name: str
    case: Case
    missing: tuple[dict[str, Any], ...] = ()
    free: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()


def base_of(kind: str, number: int, seed: int, folder: Path) -> Base:
    """The base of a number: the open challenges first, where they are at hand, then drawn ones."""
    if kind == "preset":
        scene = ("wall", "patches")[number // len(PRESETS) % 2]
        return _preset(PRESETS[number % len(PRESETS)], scene, seed + number, folder)
    listed: dict[str, tuple[str, ...]] = {"planted": OPEN_PLANTED, "null": OPEN_NULLS}
    names = listed[kind] if CHALLENGES.is_dir() else ()
    if number < len(names):
        answer = json.loads((CHALLENGES / "answers" / f"{names[number]}.json").read_text(encoding="utf-8"))
        return _labelled(names[number], opened(CHALLENGES / "cases" / names[number], MOST), answer)
    shutil.rmtree(folder, ignore_errors=True)
    family = "plain" if kind == "planted" else "null"
    made = make(family, [seed, number], folder)
    if made is None:
        raise ValueError(f"{family} needs no real recordings")
    name = f"{family} {number}, {'itof' if made.plan.flight else 'dots'} {made.label['deck']}"
    return _labelled(name, opened(folder, MOST), made.label)


def _labelled(name: str, case: Case, label: dict[str, Any]) -> Base:
    return Base(name, case, tuple(label["missing"]), tuple(label["known_truth"]), tuple(label["equivalent"]))


def _preset(name: str, scene: str, seed: int, folder: Path) -> Base:
    """Eight placements of a wall or of patches, 0.8 to 2.4 m and two tilts, as the preset's own simulation makes them.

    One run of the simulator, so that all are of one unit and no two share random numbers.
    """
    whole = simulated(scene, name, seed, folder)
    return Base(f"{name} {scene}", Case(placements(whole), name))


def simulated(scene: str, sensor: Path | str, seed: int, folder: Path, *more: object) -> Taken:
    """One recording of four distances at two tilts each by `fusion simulate`; `more` are options of its own."""
    shutil.rmtree(folder, ignore_errors=True)
    settings = ("--set", "distance_m=0.8,1.2,1.8,2.4", "--set", "tilt_deg=0,25", "--set", "frames=6", *more)
    ran = fusion("simulate", scene, *settings, "-o", folder / "rec_0", "--sensor", sensor, "--seed", seed)
    if ran.status:
        raise RuntimeError(ran.last)
    return opened(folder, 1, str(sensor)).recordings[0]


def placements(whole: Taken) -> tuple[Taken, ...]:
    """A recording of several poses as one recording each."""
    parts: list[Taken] = []
    for frames, _ in views(whole):
        stamps = whole.times[frames]
        part = retimed(whole, np.array(frames), 0.0)
        infrared = [(t, image) for t, image in whole.infrared if stamps[0] - 1e-6 <= t <= stamps[-1] + 1e-6]
        parts.append(replace(part, name=f"rec_{len(parts):02d}", infrared=infrared))
    # placed one after the other, as a user does
    return tuple(
        replace(
            retimed(part, np.arange(len(part.times)), 60.0 * k), infrared=[(t + 60.0 * k, x) for t, x in part.infrared]
        )
        for k, part in enumerate(parts)
    )
