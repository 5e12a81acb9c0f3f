"""The table of a run, as text and as JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from tools.sets.loop_scenes.judged import Judged, Side

HEAD = (
    f"{'':<13}{'':<8}{'ATE':>8}{'ratio':>7}{'placed':>11}{'drift':>8}{'':>6}{'gap':>8}{'mesh':>7}{'95 %':>7}"
    f"{'twice':>7}{'sure':>7}{'time':>7}\n"
    f"{'scene':<13}{'':<8}{'mm':>8}{'':>7}{'':>11}{'mm':>8}{'deg':>6}{'mm':>8}{'mm':>7}{'mm':>7}{'%':>7}{'%':>7}{'s':>7}"
)


def lines(one: Judged) -> str:
    """A scene: ours, Open3D's, what was asked and is not so, what was warned of."""
    out = [line(one.name, "fusion", one.own, one.ratio, f"{one.placed}/{one.frames}")]
    if one.peer:
        out.append(line("", "Open3D", one.peer, float("nan"), ""))
    out += [f"{'':<13}MISSED {text}" for text in one.misses]
    out += [f"{'':<13}warned: {text[:150]}" for text in one.alarms[:4]]
    return "\n".join(out)


def summary(scenes: Sequence[Judged]) -> str:
    """The last line: what is reached of what was asked."""
    missed = [f"{one.name} ({len(one.misses)})" for one in scenes if one.misses]
    reached = f"{len(scenes) - len(missed)} of {len(scenes)} scenes are all that was asked"
    return reached + (f"; not {', '.join(missed)}" if missed else "")


def line(name: str, program: str, side: Side, ratio: float, placed: str) -> str:
    """One program's figures; a dash is no number."""
    off, mesh, no = side.off, side.mesh, float("nan")
    figures = [off.drift * 1e3, off.drift_deg, off.gap * 1e3] if off else [no] * 3
    figures += [mesh.median * 1e3, mesh.p95 * 1e3, mesh.beyond * 100, mesh.within * 100] if mesh else [no] * 4
    widths = zip([*figures, side.seconds], (8, 6, 8, 7, 7, 7, 7, 7), (1, 2, 1, 2, 1, 1, 1, 0), strict=True)
    text = f"{name:<13}{program:<8}{number(off.ate * 1e3 if off else no, 8, 1)}{number(ratio, 7, 2)}{placed:>11}"
    return text + "".join(number(x, width, digits) for x, width, digits in widths)


def number(x: float, width: int, digits: int) -> str:
    return f"{x:>{width}.{digits}f}" if np.isfinite(x) else f"{'-':>{width}}"


def as_json(scenes: Sequence[Judged]) -> str:
    """Everything, NaN as null."""
    return json.dumps([plain(asdict(one)) for one in scenes], indent=1)


def plain(x: Any) -> Any:
    if isinstance(x, dict):
        return {key: plain(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [plain(value) for value in x]
    if isinstance(x, np.ndarray):
        return np.round(x, 9).tolist()
    return None if isinstance(x, float) and not np.isfinite(x) else x
