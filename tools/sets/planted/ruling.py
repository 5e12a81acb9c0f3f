"""Right or wrong: what was said against what had to be said, and whether all places say the same."""

import re
from dataclasses import dataclass

from tools.sets.planted.cases import LEVELS, Case
from tools.sets.planted.measure import Measured
from tools.sets.planted.said import Light, Said, squeezed

# a mesh is wrong beyond these, doubtful beyond half of them (guess: 1 mm on 0.1 m, and what is seen at once)
WRONG_SCALE, WRONG_RMS = 0.01, 0.004
CLEAN_SCALE, CLEAN_RMS = 0.005, 0.002  # asked of a clean scan
MENDED_SCALE = 0.01  # asked where the fault can be undone; the rms as of a clean one
COVERED = 0.9  # of what was seen; a scan with less has to say so

# what a closed object on a plate may always be told
ALLOWED = r"bottom|underside|stood on|stands on|plate|open surface|hole"

# a red light about one of these accuses it; symptoms (residuals, gaps, holes) may be red beside any cause
CAUSES = {
    "focal": r"focal|intrinsic|scale",
    "unit": r"unit|depth_scale",
    "range": r"range instead|along the ray",
    "slip": r"slip",
    "log": r"\blog\b|turntable_deg",
    "bump": r"camera.*(moved|bump)",
    "still": r"stands still|nothing turns",
    "partial": r"partial turn",
}


@dataclass(frozen=True)
class Ruling:
    """What was expected, what was said (both short), and what is wrong with it (empty = right)."""

    case: Case
    expected: str
    said: str
    wrong: tuple[str, ...]
    measured: Measured | None

    @property
    def right(self) -> bool:
        return not self.wrong


def harm(measured: Measured | None) -> str:
    """How bad a mesh is, as a level."""
    if measured is None:
        return "ok"
    size = max(abs(measured.scale - 1) / WRONG_SCALE, measured.rms / WRONG_RMS)
    if size > 1:
        return "bad"
    return "warning" if size > 0.5 or measured.covered < COVERED else "ok"


def rule(case: Case, said: Said, measured: Measured | None) -> Ruling:
    wrong = [*_of_clean(said, measured)] if not case.planted else [*_of_fault(case, said, measured)]
    if said.status == 0:
        wrong += disagreements(said)
    return Ruling(case, _expected(case, measured), _short(said), tuple(wrong), measured)


def _of_clean(said: Said, measured: Measured | None) -> list[str]:
    if said.status:
        return [f"ended with status {said.status}"]
    out = [f"false alarm: {x.level} {x.text}" for x in said.lights or () if _alarm(x)]
    return out + _mesh_faults(measured, CLEAN_SCALE)


def _alarm(light: Light) -> bool:
    return light.level == "bad" or (light.level == "warning" and not re.search(ALLOWED, light.text, re.IGNORECASE))


def _mesh_faults(measured: Measured | None, scale: float) -> list[str]:
    if measured is None:
        return ["no mesh"]
    out = []
    if abs(measured.scale - 1) > scale:
        out.append(f"mesh {measured.scale - 1:+.1%} in scale")
    if measured.rms > CLEAN_RMS:
        out.append(f"mesh {measured.rms * 1e3:.1f} mm rms")
    return out


def _of_fault(case: Case, said: Said, measured: Measured | None) -> list[str]:
    expected = case.expected
    if said.status:
        return _of_refusal(case, said)
    if expected.refusal == "must":
        return ["no refusal"]
    least = max(expected.least, harm(measured), key=LEVELS.index)
    lights = said.lights or ()
    own = [x for x in lights if re.search(expected.about, x.text, re.IGNORECASE)]
    out = []
    if not own:
        out.append("not told")
    elif max(LEVELS.index(x.level) for x in own) < LEVELS.index(least):
        out.append(f"told as {max((x.level for x in own), key=LEVELS.index)}, has to be {least}")
    foreign = [x for x in lights if x.level == "bad" and x not in own]
    out += [f"accuses {x.subject!r}" for x in foreign if any(re.search(c, x.subject, re.I) for c in CAUSES.values())]
    if expected.mended:
        out += _mesh_faults(measured, MENDED_SCALE)
    if expected.camera_kept and said.refined:
        out.append("a calibrated camera was replaced")
    return out


def _of_refusal(case: Case, said: Said) -> list[str]:
    if case.expected.refusal == "never":
        return [f"ended with status {said.status}"]
    lines = [line for line in said.terminal.strip().splitlines() if line.strip()]
    last = lines[-1] if lines else ""
    out = [] if said.status == 1 else [f"status {said.status}"]
    if "Traceback" in said.terminal:
        out.append("traceback")
    if said.mesh is not None:
        out.append("a mesh was left")
    return out if re.search(case.expected.about, last, re.IGNORECASE) else [*out, "refused without the reason"]


def disagreements(said: Said) -> list[str]:
    """Page, terminal and JSON tell the same, the worst first, each once."""
    if said.lights is None:
        return ["no judgement in settings.json"]
    out, levels = [], [LEVELS.index(x.level) for x in said.lights]
    if levels != sorted(levels, reverse=True):
        out.append("not the worst first")
    if len(set(said.warnings)) < len(said.warnings):
        out.append("a warning twice")
    told = [x for x in said.lights if x.level != "ok"]
    for place, text in (("page", said.page), ("terminal", squeezed(said.terminal))):
        at = [text.find(squeezed(x.reason)) for x in told]
        if -1 in at:
            out.append(f"{place} lacks: {told[at.index(-1)].subject}")
        elif at != sorted(at):
            out.append(f"{place} in another order")
    return out


def _expected(case: Case, measured: Measured | None) -> str:
    if not case.planted:
        return "no alarm"
    if case.expected.refusal == "must":
        return "refusal"
    level = max(case.expected.least, harm(measured), key=LEVELS.index)
    return {"ok": "told", "warning": "yellow", "bad": "red"}[level] + {"may": " or refusal"}.get(
        case.expected.refusal, ""
    )


def _short(said: Said) -> str:
    if said.status:
        lines = [line for line in said.terminal.strip().splitlines() if line.strip()]
        return f"status {said.status}: {lines[-1] if lines else ''}"
    if said.lights is None:
        return f"verdict {said.verdict}: {'; '.join((*said.reasons, *said.warnings)) or 'nothing'}"
    return "; ".join(f"{x.level} {x.text}" for x in said.lights if x.level != "ok") or "all ok"
