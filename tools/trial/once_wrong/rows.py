"""All rows, in the order in which they were seen, each with variants of its own."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from tools.trial.concealed.laws import invented, named
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.laws.matching import Matching
from tools.trial.once_wrong.own import beside_steps, lacking, moving, preset
from tools.trial.once_wrong.planted import of_size, planted
from tools.trial.once_wrong.row import Makes, Row
from tools.trial.spoiled.bases import Base, base_of
from tools.trial.spoiled.case import Case, Rng, Spoiled, Told
from tools.trial.spoiled.catalogue import SPOILS
from tools.trial.spoiled.places import centre_by, poses_by
from tools.trial.spoiled.replicas import retimed
from tools.trial.spoiled.surfaces import bowed_by, shaken_by

FIRST = 2  # base of the stress test that is drawn and no open challenge
FACTORS = (10.0, 5.0, 20.0, 8.0)  # the row itself, then three of its relatives
PIXELS = (("cx", 3.0), ("cx", -2.0), ("cy", 4.0), ("cy", -3.0))
BOWS_M = (0.0012, 0.0006, 0.002, 0.0009)
COPIES = (8, 2, 4, 12)


def _spoiled(spoil: str) -> Makes:
    return lambda variant, rng, folder: _on_null(variant, rng, folder, SPOILS[spoil])


def _on_null(variant: int, rng: Rng, folder: Path, spoil: Callable[[Case, Rng], Spoiled]) -> tuple[Base, Spoiled]:
    base = base_of("null", FIRST + variant, int(rng.integers(2**31)), folder)
    return base, spoil(base.case, rng)


def _poses(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
    return _on_null(variant, rng, folder, lambda case, own: poses_by(case, FACTORS[variant % 4], own))


def _centre(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
    return _on_null(variant, rng, folder, lambda case, _: centre_by(case, *PIXELS[variant % 4]))


def _bowed(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
    return _on_null(variant, rng, folder, lambda case, own: bowed_by(case, BOWS_M[variant % 4], own))


def _shaken(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
    strength = (1.0, 0.3, 0.6, 0.8)[variant % 4]
    return _on_null(variant, rng, folder, lambda case, own: shaken_by(case, strength, own))


def _copies(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
    return _on_null(variant, rng, folder, lambda case, _: _one_copied(case, COPIES[variant % 4]))


def _one_copied(case: Case, count: int) -> Spoiled:
    """One recording and nothing but its copies, by other names and times."""
    one = min(case.recordings, key=lambda taken: len(taken.times))
    frames = np.arange(len(one.times))
    copies = []
    for k in range(count):
        infrared = [(t + 100.0 * k, image) for t, image in one.infrared]
        copies.append(replace(retimed(one, frames, 100.0 * k), name=f"rec_{k:02d}", infrared=infrared))
    told = Told("cop(y|ies)|twice|same", refused="cop(y|ies)|twice|same")
    return Spoiled(Case(tuple(copies), case.sensor), f"{count} copies", told)


def _odd_wave(rng: Rng) -> Law:
    makers = [invented.FLIGHT[name] for name in ("row_wave", "rings", "brightness_wave")]
    return makers[int(rng.integers(len(makers)))](rng)


ROWS = (
    Row("poses 10 times worse than stated", "unknown(time, depth, range), p 5e-149", _poses),
    Row("camera file with cx off by 3 px", "unknown(time, depth, range)", _centre),
    Row("walls bowed by 1.2 mm, unsaid", "unknown(u, depth)", _bowed),
    Row("each scene recorded twice", "unknown(u)", _spoiled("repeat")),
    Row("copies of one recording", "fixed_pattern, p 2e-124", _copies),
    Row("kinect-v1, its own simulation, small images", "pixel_locking, unknown", preset("kinect-v1", "wall", True)),
    Row("kinect-v1, its own simulation", "disparity_distortion, fixed_pattern", preset("kinect-v1", "wall"), True),
    Row("kinect-v2-indoors, its own simulation", "principal_point", preset("kinect-v2-indoors", "wall"), True),
    Row("every frame shaken by 5 mm, 3 mrad", "nothing is missing, chi2 0.14", _shaken),
    Row("no noise law in sensor.json", "noise not named, chi2 4", _spoiled("noise")),
    Row("a thing before the wall", "nothing is missing, drift 4.7 mm", _spoiled("clutter")),
    Row("speckle of 0.05 px", "pixel_locking", planted(
        "walls", False, device=Matching(speckle=0.05), unsaid="speckle_noise")),
    Row("principal point off by 3 px", "not established", lacking(
        "itof", "wall", "principal_point", cx=(3.0, "px"))),
    Row("disparity off by 0.15 px", "vertical_banding", planted(
        "walls", False, of_size(named.MATCHING["disparity_offset"], 15.0))),
    Row("light by way of a corner", "129 of chi2 left", planted("corner", True, of_size(named.multipath, 1.0))),
    Row("fixed pattern of 3 mm", "rms 0.2", lacking(
        "structured_light", "patches", "fixed_pattern", rms=(0.003, "m"))),
    Row("delay along columns beside a decoy", "fixed_pattern", planted(
        "sides", True, named.column_delay, strength=0.6, family="decoy")),
    Row("a pane of glass", "unknown", lacking(
        "itof", "wall", "refraction", thickness=(0.004, "m"), index=(1.5, "1"))),
    Row("warming up", "silent", planted("warm", True, named.FLIGHT["temperature_drift"], strength=0.6)),
    Row("warming up, disparities", "silent", planted(
        "warm", False, named.MATCHING["temperature_drift"], strength=0.6)),
    Row("shadow of the projector", "silent", beside_steps("projector_shadow", baseline=(-0.075, "m"))),
    Row("values lost in the dark", "silent", planted("patches", True, invented.darker)),
    Row("cyclic error with stray light", "unknown", planted(
        "card", True, named.cyclic_error, named.stray_light, strength=0.6, family="mixture")),
    Row("a wave that no catalogue has", "silent", planted("walls", True, _odd_wave, strength=0.8)),
    Row("late pictures of a moving camera", "nothing is missing, chi2 11.5", moving(
        "timestamp_offset", offset=(0.02, "s"))),
)  # fmt: skip
