"""Every effect at its typical size, recorded as its page says: does `fusion explain` name it?

    python -m tools.reproduce.named_effects -o OUT --seed 1                all effects, some half an hour
    python -m tools.reproduce.named_effects -o OUT --only cyclic_error
    python -m tools.reproduce.named_effects -o OUT --write                 and docs/explain_effects.md from what came

The recordings are simulated by the package itself, so this asks whether what the catalogue holds can be told apart, not
whether it is true of sensors: tools/trial has other hands' recordings. The model that is explained has the noise and
not the effect; poses are as sure as the scenes state them. "named": it is established; "set": it is in an established
set of at most three that look alike; "indicated": likely, not established, or one of more than three; "invisible": said
to be what these data cannot show; "silent": nothing of it; "WRONG": something else is established, whatever else is.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

from fusion.errors import SensorError
from fusion.files.content import Content
from fusion.files.output.publish import atomic_file
from fusion.geometry.camera import Camera, Principle
from fusion.recording.cameras.presets import find_camera
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.files.entries import given_effects
from fusion.sensor.files.sensor_fields import FORMAT
from fusion.sensor.files.sensor_file import write_sensor
from fusion.sensor.sensor import Sensor
from fusion.simulation.scenes import built_in
from fusion.simulation.simulate import simulate
from fusion.simulation.write import write_simulation
from tools.documentation.effect_pages.recordings import ADVICE, SERIES, advice
from tools.documentation.effect_pages.text import example

GENERIC = {"tabulated": "unknown"}  # a table of any shape has no name: what is right to say of it
SMALL = {Principle.TIME_OF_FLIGHT: ("kinect-v2", (256, 212)), Principle.STRUCTURED_LIGHT: ("kinect-v1", (320, 240))}
NOISE = {
    Principle.TIME_OF_FLIGHT: AxialNoise(c0=0.001, shot=0.002, floor=0.001, ir_reference=1000.0),
    Principle.STRUCTURED_LIGHT: AxialNoise(sigma_px=0.05),
}
LARGEST_SET = 3
PAGE = Path(__file__).resolve().parents[2] / "docs" / "explain_effects.md"
ORDER = ("named", "set", "indicated", "invisible", "silent", "WRONG", "failed")


@dataclass(frozen=True)
class Answer:
    """What was said of one effect."""

    effect: str
    outcome: str  # see above
    claims: tuple[str, ...]  # established, sets with a stroke between
    seconds: float


def main() -> int:
    """Make, explain, tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", metavar="EFFECT", choices=sorted(ADVICE), default=sorted(ADVICE))
    parser.add_argument("--write", action="store_true", help="the page of docs from these answers")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    kinds = [kind for kind in EFFECTS if kind.name in options.only]
    for kind in kinds:
        file = options.output / f"{kind.name}.json"
        if not file.exists():
            answer = _asked(kind, options.output / kind.name, options.seed)
            file.write_text(json.dumps(asdict(answer)), encoding="utf-8")
        print(_line(_read(file)), flush=True)
    answers = [_read(options.output / f"{kind.name}.json") for kind in kinds]
    print(_count(answers))
    if options.write:  # of what was asked: the page tells which were not
        with atomic_file(PAGE) as partial:
            partial.write_text(_page(answers, options.seed), encoding="utf-8")
    return 0


def planted(kind: type[Effect]) -> Effect:
    """The effect as its page shows it in a `sensor.json`: typical values of its first group of parameters."""
    content = Content({"format": FORMAT, "effects": [example(kind)]}, kind.name, error=SensorError)
    return given_effects(content)[0].effect()


def _asked(kind: type[Effect], folder: Path, seed: int) -> Answer:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    principle = kind.principles[0] if kind.principles else Principle.TIME_OF_FLIGHT
    name, size = SMALL[principle]
    camera = find_camera(name).resized(*size)
    noise = () if kind is AxialNoise else (NOISE[principle],)
    model = Sensor(name="model", principle=principle, effects=noise)
    write_sensor(folder / "sensor.json", model)
    _record(kind, folder, model.having(planted(kind)), camera, seed)
    recordings = sorted(str(path) for path in folder.glob("rec_*"))
    arguments = ["explain", *recordings, "--sensor", str(folder / "sensor.json"), "-o", str(folder / "out")]
    command = [sys.executable, "-c", "from fusion.commands.console import run; run()", *arguments, "--no-report", "-q"]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        return Answer(kind.name, "failed", (run.stderr.strip().split("\n")[-1][:200],), 0.0)
    verdict = json.loads((folder / "out" / "verdict.json").read_text(encoding="utf-8"))
    shutil.rmtree(folder)
    return judged(kind.name, verdict)


def _record(kind: type[Effect], folder: Path, sensor: Sensor, camera: Camera, seed: int) -> None:
    takes = [(take, SERIES[series].counts) for series in ADVICE[kind.name] for take in SERIES[series].takes]
    for number, (take, counts) in enumerate(takes):
        scene = replace(built_in(take.scene, take.settings), camera=replace(camera, depth_scale=counts))
        write_simulation(folder / f"rec_{number:02d}", simulate(scene, sensor, seed * 1000 + number))


def judged(name: str, verdict: dict[str, Any]) -> Answer:
    """What a verdict is worth for an effect that was planted."""
    effect = GENERIC.get(name, name)
    sets = [(claim["effect"], *claim["indistinguishable_from"]) for claim in verdict["missing"]]
    claims = tuple(" | ".join(said) for said in sets)
    seconds = float(sum((verdict.get("seconds") or {}).values()))
    likely = {one for claim in verdict["indicated"] for one in (claim["effect"], *claim["indistinguishable_from"])}
    if any(effect not in said for said in sets):
        outcome = "WRONG"
    elif sets:
        outcome = "named" if sets[0][0] == effect and len(sets[0]) == 1 else "set"
        outcome = outcome if len(sets[0]) <= LARGEST_SET else "indicated"
    else:
        outcome = "indicated" if effect in likely else "invisible" if effect in verdict["invisible"] else "silent"
    return Answer(name, outcome, claims, seconds)


def _read(file: Path) -> Answer:
    fields = json.loads(file.read_text(encoding="utf-8"))
    return Answer(fields["effect"], fields["outcome"], tuple(fields["claims"]), fields["seconds"])


def _line(answer: Answer) -> str:
    return f"{answer.effect:<26} {answer.outcome:<10} {answer.seconds:5.0f} s  {', '.join(answer.claims)}"


def _count(answers: list[Answer]) -> str:
    counts = {word: sum(answer.outcome == word for answer in answers) for word in ORDER}
    return f"{len(answers)} effects: " + ", ".join(f"{word} {count}" for word, count in counts.items() if count)


def _page(answers: list[Answer], seed: int) -> str:
    rows = [f"| [{a.effect}](effects/{a.effect}.md) | {a.outcome} | {', '.join(a.claims).replace('|', 'or')} "
            f"| {advice(a.effect)} |" for a in answers]  # fmt: skip
    open_ = sorted(set(ADVICE) - {answer.effect for answer in answers})
    return "\n".join([
        "# Which effects `fusion explain` can name",
        "",
        "Each at its typical size, recorded as its page says, in simulated recordings of this package: the catalogue",
        "is asked whether its laws can be told apart. Recordings by other hands are in [the trial](explain_trial.md).",
        "*named*: established alone; *set*: one of at most three that look alike; *indicated*: likely, or one of more",
        "than three; *invisible*: said to be what these data cannot show; *silent*: nothing of it; *WRONG*: something",
        "else is established.",
        "",
        _count(answers) + "." + (f" Not asked yet: {', '.join(open_)}." if open_ else ""),
        "",
        "| effect | said | established | recorded |",
        "|---|---|---|---|",
        *rows,
        "",
        f"Made by `python -m tools.reproduce.named_effects -o OUT --seed {seed} --write`.",
        "",
    ])  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
