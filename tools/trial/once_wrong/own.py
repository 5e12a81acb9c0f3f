"""Rows whose recordings `fusion simulate` makes: presets against their own simulation, and effects planted alone."""

import json
from pathlib import Path
from typing import Any

from tools.sets.judging.command import fusion
from tools.trial.once_wrong.row import NOTHING, Makes, Rng
from tools.trial.spoiled.bases import Base, placements, simulated
from tools.trial.spoiled.case import Case, Spoiled, opened

SMALL = {"width": 208, "height": 160, "cx": 103.2, "cy": 79.9, "distortion": [0.0] * 5, "depth_scale": 5000}
FOCAL = {"structured_light": 185.0, "itof": 152.0}


def preset(name: str, scene: str, small: bool = False) -> Makes:
    """A preset against its own simulation: nothing is missing."""

    def make(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
        more = ("--camera", _camera(folder, "structured_light")) if small else ()
        whole = simulated(scene, name, int(rng.integers(2**31)), folder, *more)
        case = Case(placements(whole), name)
        return Base(f"{name} {scene}", case), Spoiled(case, "", NOTHING)

    return make


def lacking(principle: str, scene: str, effect: str, *more: object, **values: tuple[float, str]) -> Makes:
    """A small camera with noise and rounding, and one effect that its model does not hold."""

    def make(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
        known = _model(principle)
        full = {**known, "effects": [_entry(effect, **values), *known["effects"]]}
        file = folder.with_suffix(".json")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(full), encoding="utf-8")
        options = ("--camera", _camera(folder, principle), *more)
        whole = simulated(scene, file, int(rng.integers(2**31)), folder, *options)
        case = Case(placements(whole), known)
        return Base(f"{effect} {scene}", case, ({"effect": effect},)), Spoiled(case, "", NOTHING)

    return make


def beside_steps(effect: str, **values: tuple[float, str]) -> Makes:
    """A triangulating camera before plates that stand before walls, five recordings."""

    def make(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
        known, file = _model("structured_light"), folder.with_suffix(".json")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps({**known, "effects": [_entry(effect, **values), *known["effects"]]}), "utf-8")
        for k in range(5):
            place = f"distance_m={rng.uniform(0.7, 1.6):.3f}", f"step_m={rng.uniform(0.25, 0.6):.3f}"
            options = ("--camera", _camera(folder, "structured_light"), "--sensor", file, "--seed", k + 10 * variant)
            ran = fusion("simulate", "step", "--set", place[0], "--set", place[1], *options, "-o", folder / f"rec_{k}")
            if ran.status:
                raise RuntimeError(ran.last)
        case = Case(opened(folder, 5, str(file)).recordings, known)
        return Base(f"{effect} step", case, ({"effect": effect},)), Spoiled(case, "", NOTHING)

    return make


def moving(effect: str, **values: tuple[float, str]) -> Makes:
    """A camera in a hand that moves through a room."""

    def make(variant: int, rng: Rng, folder: Path) -> tuple[Base, Spoiled]:
        known = _model("itof")
        file = folder.with_suffix(".json")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps({**known, "effects": [_entry(effect, **values), *known["effects"]]}), "utf-8")
        options = ("--camera", _camera(folder, "itof"), "--set", "frames=60", "--seed", int(rng.integers(2**31)))
        ran = fusion("simulate", "room", *options, "-o", folder / "rec_0", "--sensor", file)
        if ran.status:
            raise RuntimeError(ran.last)
        case = Case(opened(folder, 1, str(file)).recordings, known)
        return Base(f"{effect} room", case, ({"effect": effect},)), Spoiled(case, "", NOTHING)

    return make


def _camera(folder: Path, principle: str) -> Path:
    file = folder.with_name(f"{folder.name}_camera.json")
    file.parent.mkdir(parents=True, exist_ok=True)
    f = FOCAL[principle]
    file.write_text(json.dumps({**SMALL, "fx": f, "fy": f, "principle": principle, "sensor": "made"}), "utf-8")
    return file


def _model(principle: str) -> dict[str, Any]:
    flight = principle == "itof"
    noise = {"c0": (0.002, "m")} if flight else {"sigma_px": (0.03, "px")}
    rounding = {"step": (0.001, "m")} if flight else {"step_px": (0.0625, "px")}
    effects = [_entry("axial_noise", **noise), _entry("depth_quantization", **rounding)]
    about = {"format": "fusion-sensor/1", "name": "made", "principle": principle}
    return {**about, **({} if flight else {"baseline_m": 0.075}), "effects": effects}


def _entry(effect: str, **values: tuple[float, str]) -> dict[str, Any]:
    parameters = {name: {"value": x, "unit": unit, "std": 0.0} for name, (x, unit) in values.items()}
    return {"effect": effect, "parameters": parameters, "source": "planted"}
