"""The words of the effect pages: everything is taken from the effect objects."""

import inspect
import json
import sys
from types import ModuleType
from typing import Any

from fusion.geometry.camera import Principle
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import Parameter, parameters, settings
from fusion.sensor.words.in_words import in_words
from tools.documentation.effect_pages.recordings import advice

COMMAND = "python -m tools.documentation.effects"
ROOMS = ("rig", "optics", "light", "triangulation", "phase", "readout")
CHANNELS = {"bias": "bias", "noise": "noise", "spread": "noise", "dropout": "dropout", "light": "light"}
SENSORS = {
    (): "all",
    (Principle.TIME_OF_FLIGHT,): "time of flight",
    (Principle.STRUCTURED_LIGHT,): "structured light",
    (Principle.STRUCTURED_LIGHT, Principle.ACTIVE_STEREO): "triangulation",
}
FROZEN = " (frozen: the bias repeats in every frame, the noise is how it spreads where it is not known)"
KINDS = {
    "list": "; one value, or a list",
    "map": "; one value per pixel, as a `.npy` file",
    "table": "; one value per node of the grid",
}
LEGEND = """\
*bias*: the mean depth; *noise*: its spread; *dropout*: whether there is a value at all; *light*: the amplitude, and
with it all that depends on it. *Undone* tells whether the correction takes the change of the depth back; values that
are only usual ones, not calibrated for the unit at hand, are never taken back.
"""


def page(kind: type[Effect]) -> str:
    """One effect as Markdown."""
    title, happens = summary(kind)
    about = _paragraphs(inspect.getdoc(kind) or "")
    parts = [
        f"# {title} (`{kind.name}`)",
        happens[0].upper() + happens[1:],
        *about,
        f"![{kind.name}]({kind.name}.svg)",
        "Strong: at typical values. Pale: at half of them.",
        "    " + "\n    ".join(kind.formula.replace("`", "").split("; ")),
        _facts(kind),
        "## Parameters",
        _parameter_table(kind),
        "## What to record",
        f"So that `fusion explain` can name it: {advice(kind.name)[0].lower()}{advice(kind.name)[1:]} "
        "[What it says of each effect then](../explain_effects.md).",
        "## In a `sensor.json`",
        f"```json\n{_json(example(kind))}\n```",
        f"Made by `{COMMAND}` from [{_source(kind)}](../../{_source(kind)}); change the text there. "
        "[All effects](README.md)",
    ]
    return "\n\n".join(parts) + "\n"


def index() -> str:
    """The list of all effects as Markdown."""
    parts = [
        "# Sensor effects",
        "Each error of a depth camera is one effect: a law with parameters that have units, bounds and sources. A "
        "`sensor.json` lists the effects of one sensor; simulation, correction, weights and the comparison with a real "
        "recording all follow from it. Effects act in the order of this page, which is that of the light.",
        LEGEND.strip(),
    ]
    for room in ROOMS:
        module = sys.modules[f"fusion.sensor.effects.{room}"]
        parts += [f"## {_first_line(module)}", table([k for k in EFFECTS if _room(k) == room])]
    return "\n\n".join([*parts, f"Made by `{COMMAND}`."]) + "\n"


def table(kinds: list[type[Effect]]) -> str:
    """One row per effect: name, what it does, channels, sensors, corrected or not."""
    rows = ["| effect | what it does | changes | sensors | corrected |", "|---|---|---|---|---|"]
    for kind in kinds:
        does = summary(kind)[1].rstrip(".")
        link = f"[{kind.name}]({kind.name}.md)"
        rows.append(f"| {link} | {_cell(does)} | {channels(kind)} | {sensors(kind)} | {corrected(kind)[0]} |")
    return "\n".join(rows)


def summary(kind: type[Effect]) -> tuple[str, str]:
    """The effect's name in words, and the sentence that tells what happens."""
    said = in_words(kind)
    if not said.happens:
        raise ValueError(f"the first line of {_source(kind)} is not 'Name: what happens.'")
    return said.title, said.happens


def channels(kind: type[Effect]) -> str:
    """What an effect changes, in words."""
    return ", ".join(dict.fromkeys(word for own, word in CHANNELS.items() if kind.changes(own)))


def sensors(kind: type[Effect]) -> str:
    """The sensors that can have an effect, in words."""
    return SENSORS[kind.principles]


def corrected(kind: type[Effect]) -> tuple[str, str]:
    """Whether the correction undoes an effect: one word, and a sentence."""
    if not kind.changes("bias"):
        return "-", "there is nothing to correct, as the mean depth stays"
    if kind.not_corrected:
        return "no", f"no: {kind.not_corrected}"
    if kind.frozen:
        return "yes", "yes, once its values are known for this very unit"
    if kind.why_not_corrected is not Effect.why_not_corrected:
        return "yes", "yes, unless its law is so steep that two depths give the same value"
    return "yes", "yes"


def example(kind: type[Effect]) -> dict[str, Any]:
    """An entry of `sensor.json` with typical values of the first group of parameters."""
    known = list(parameters(kind).values())
    first = next((p.group for p in known if p.group), "")
    values: dict[str, Any] = {}
    if settings(kind):  # a table has no typical layout
        values = {"variables": {"value": ["depth"]}, "grid": {"value": [[0.5, 0.7, 1.0, 1.5, 4.0]]}}
        values["values"] = {"value": [0.012, 0.005, 0.002, 0.0, 0.0], "unit": "m"}
        return {"effect": kind.name, "parameters": values, "source": "an example"}
    grouped = {p.group for p in known if p.group}
    for about in known:
        if about.group in ("", first) or (len(grouped) == 1):
            value = [about.typical] if about.kind == "list" else about.typical
            values.setdefault(about.label, {"value": value, "unit": about.unit})
    return {"effect": kind.name, "parameters": values, "source": "an example"}


def _facts(kind: type[Effect]) -> str:
    depends = kind.variables if isinstance(kind.variables, tuple) else ()
    rows = {
        "depends on": ", ".join(depends).replace("_", " ") or ("what the table says" if settings(kind) else "nothing"),
        "changes": channels(kind) + (FROZEN if kind.frozen else ""),
        "sensors": sensors(kind),
        "corrected": corrected(kind)[1],
    }
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {_cell(text)} |" for name, text in rows.items())])


def _parameter_table(kind: type[Effect]) -> str:
    rows = ["| parameter | unit | neutral | bounds | typical | meaning | source |", "|---|---|---|---|---|---|---|"]
    rows += [f"| `{s.name}` | {s.kind} | | | | {_cell(s.meaning)} | |" for s in settings(kind).values()]
    return "\n".join([*rows, *(_row(about) for about in parameters(kind).values())])


def _row(about: Parameter) -> str:
    numbers = f"{about.neutral:g} | {about.low:g} to {about.high:g} | {about.typical:g}"
    meaning = _cell(about.meaning) + KINDS.get(about.kind, "")
    return f"| `{about.label}` | {about.unit} | {numbers} | {meaning} | {_cell(about.source)} |"


def _json(entry: dict[str, Any]) -> str:
    """One line per parameter."""
    lines = [f'    "{name}": {json.dumps(value)}' for name, value in entry["parameters"].items()]
    inner = ",\n".join(lines)
    return (
        f'{{\n  "effect": "{entry["effect"]}",\n  "parameters": {{\n{inner}\n  }},\n  "source": "{entry["source"]}"\n}}'
    )


def _paragraphs(text: str) -> list[str]:
    return [_plain(" ".join(part.split())) for part in text.split("\n\n")]


def _plain(text: str) -> str:
    """Text without signs that Markdown takes for its own."""
    return text.replace("*", r"\*").replace("<", "&lt;")


def _cell(text: str) -> str:
    return _plain(" ".join(text.split())).replace("|", r"\|")


def _first_line(module: ModuleType) -> str:
    return (module.__doc__ or "").strip().split("\n\n")[0].replace("\n", " ")


def _room(kind: type[Effect]) -> str:
    return kind.__module__.split(".")[-2]


def _source(kind: type[Effect]) -> str:
    return kind.__module__.replace(".", "/") + ".py"
