"""One case: a sensor, a scene, a motion and what is concealed, drawn again until it can be seen."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tools.trial.furnished.answers import answer_of
from tools.trial.furnished.cameras import sensor_file
from tools.trial.furnished.motions import CameraWalk, ViewDraws, put_poses_wrong, walk
from tools.trial.furnished.physics.bench import Bench
from tools.trial.furnished.physics.sensor import Effects
from tools.trial.furnished.physics.world import World
from tools.trial.furnished.placing import must_be_seen
from tools.trial.furnished.plan import Spec, easier
from tools.trial.furnished.planted.catalogue import plant
from tools.trial.furnished.planted.plant import Planted
from tools.trial.furnished.rooms.parts import merge
from tools.trial.furnished.staging import SHARP, DrawnStage, staged, weakest_of
from tools.trial.furnished.visibility import Visibility, visibility
from tools.trial.furnished.writing import CaseTold, write_case

Rng = np.random.Generator
ATTEMPTS, EASIER_AFTER = 14, 8
LEAST = 10.0  # standard deviations that an effect must show with
BUDGET = {8: 3e5, 32: 1e6, 160: 1.6e6, 320: 5e6}  # pixels of all frames, by the width of an image
cv2.setNumThreads(2)


@dataclass(frozen=True)
class MadeCase:
    """`answer` is None, and `why` told, where a case could not be made."""

    answer: dict[str, Any] | None
    why: str = ""


def made(seed: int, case: int, spec: Spec, out: Path) -> MadeCase:
    """Makes `out`/cases/case_NNN with its answer beside it; one whose answer is there is kept."""
    file = out / "answers" / f"{name_of(case)}.json"
    if file.exists():
        return MadeCase(json.loads(file.read_text(encoding="utf-8")))
    shutil.rmtree(out / "cases" / name_of(case), ignore_errors=True)
    last = MadeCase(None)
    for attempt in range(ATTEMPTS):
        first = np.exp(np.random.default_rng([seed, case, 5]).uniform(np.log(0.25), 0))
        boost = min(1.6, first * 1.4**attempt)
        if attempt == EASIER_AFTER and spec.effects:
            spec = easier(seed, case)
        try:
            last = _attempt(seed, case, spec, out, attempt, boost)
        except RuntimeError as error:
            last = MadeCase(None, str(error))
        if last.answer is not None:
            break
    return last


def name_of(case: int) -> str:
    return f"case_{case:03d}"


def _attempt(seed: int, case: int, spec: Spec, out: Path, attempt: int, boost: float) -> MadeCase:
    own = int(np.random.SeedSequence([seed, case, attempt]).generate_state(1)[0] % 2**31)
    rng = np.random.default_rng(own)
    stage = staged(rng, spec)
    bench = _bench(rng, stage, own)
    moves, notes = _walk(rng, spec, stage, bench, own)
    if stage.placed.changed is not None:
        must_be_seen(bench, moves.recordings, stage.placed.changed)
    if stage.sensor.flight:
        stage.sensor.dropout = weakest_of(stage.sensor)
    plants = [plant(name, rng, bench, moves.recordings, boost) for name in spec.effects]
    sigmas = []
    for name, one in zip(spec.effects, plants, strict=True):
        seen = visibility(bench, moves.recordings, one.effects, moves.sigma, one.channel)
        sigmas.append(seen.sigma)
        if seen.sigma < LEAST:
            return MadeCase(None, f"{name}: sigma {seen.sigma:.1f}")
    bench.casts.clear()
    effects = Effects()
    for one in plants:
        effects.update(one.effects)
    write_case(out / "cases" / name_of(case), bench, moves, effects, _told(rng, spec, stage, plants))
    answer = answer_of(spec, stage, moves, plants, sigmas, notes)
    _keep(out, name_of(case), answer)
    if plants:
        _keep_shifts(
            out, name_of(case), bench, moves, visibility(bench, moves.recordings, effects, moves.sigma, "bias")
        )
    return MadeCase(answer)


def _bench(rng: Rng, stage: DrawnStage, seed: int) -> Bench:
    ambient, rise = rng.uniform(20, 25), rng.uniform(9, 20)
    settling, zero = rng.uniform(300, 1200), rng.uniform(28, 34)
    true = stage.placed.true
    return Bench(stage.sensor, stage.camera, World(merge(true)), true, seed, ambient, rise, settling, zero)


def _walk(rng: Rng, spec: Spec, stage: DrawnStage, bench: Bench, seed: int) -> tuple[CameraWalk, list[str]]:
    """Recordings with their true poses, and what is to be noted of the case."""
    camera = stage.camera
    budget = 0.8e6 if set(spec.effects) & SHARP else BUDGET[camera.width]
    if stage.kind == "zone":
        budget = camera.width * camera.height * 10 * 20
    moves = walk(ViewDraws(rng, bench.world, stage.scene, camera), stage.motion, budget)
    zones_stand = stage.kind == "zone" and moves.recordings[0].static
    for one in moves.recordings:
        times = one.times[0] + np.arange(20) / 15.0 if zones_stand else one.times
        one.times = np.round(times, 6)
    factor, notes = stage.pose_factor, list(stage.placed.notes)
    if spec.effects and rng.random() < 0.12:
        factor = 2.0
        notes.append("poses twice worse than stated")
    put_poses_wrong(moves.recordings, moves.sigma, factor, seed)
    return moves, notes


def _told(rng: Rng, spec: Spec, stage: DrawnStage, plants: list[Planted]) -> CaseTold:
    names, without = set(spec.effects), frozenset().union(*(one.without for one in plants))
    drifting = bool(names & {"temperature_drift", "projector_thermal_drift"})
    telemetry = rng.random() < 0.4 or drifting or "warm" in spec.null
    if "temperature_drift" in names and rng.random() < 0.3:
        telemetry = False
    lux = None if "ambient_light" in names or rng.random() < 0.5 else 300.0
    sensor = sensor_file(stage.sensor, stage.camera, stage.name, without)
    return CaseTold(stage.placed.stated, sensor, telemetry, lux)


def _keep(out: Path, name: str, answer: dict[str, Any]) -> None:
    folder = out / "answers"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps(answer, indent=1), encoding="utf-8")


def _keep_shifts(out: Path, name: str, bench: Bench, moves: CameraWalk, seen: Visibility) -> None:
    """The expected change of depth, for the check alone."""
    bench.casts.clear()
    (out / "check").mkdir(parents=True, exist_ok=True)
    shifts = {f"s{one.index}": x for one, x in zip(moves.recordings, seen.shifts, strict=True)}
    np.savez_compressed(out / "check" / f"{name}.npz", **shifts)  # type: ignore[arg-type]
