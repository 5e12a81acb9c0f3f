"""Is `sigma` right? Simulated scans, the true error of every vertex beside the standard deviation that it carries.

    python -m tools.sets.sigma_coverage -o OUT --scans 20 --seed 1    what is reported; looked at once
    python -m tools.sets.sigma_coverage -o OUT --seed 101             to develop on: 101 and more

Three generators take turns, none of which shares code with the package: the clean cases of tools/sets/planted, scans of
tools/sets/hard that can be done, units of tools/sets/fresh that their owner calibrates from boards and walls. The
cameras of tools/sets/hard get a focal length that is wrong by a draw of 0.1 % and state that, as a calibrated one does;
what the others state is theirs. `fusion turntable` is run as a user runs it; the mesh is turned and moved onto the
truth by the judge's own fit. A share of the surface is by area. A scan that ends with status 1 hands out no mesh and is
listed.

`OUT/table.txt` and `OUT/table.json` hold what is printed. The same seed makes the same scans.
"""

import json
import os
import shutil
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np

from tools.sets.fresh import making as fresh_making
from tools.sets.fresh import unit as fresh_unit
from tools.sets.hard import drawing as hard_drawing
from tools.sets.hard import making as hard_making
from tools.sets.judging.command import fusion
from tools.sets.judging.coverage import Coverage, coverage
from tools.sets.judging.said import content
from tools.sets.judging.series import Series, Table, options_of
from tools.sets.planted import making as planted_making
from tools.sets.planted.cases import CLEAN

KINDS = ("planted", "hard", "fresh")
STD = 0.001  # relative standard deviation of a calibrated focal length
LOW, HIGH = 0.85, 0.95  # share of the surface within 1.645 sigma that is asked
BULKY = ("recording", "masked", "board", "wall_*", "scan", "clean", "compare", "result")


@dataclass(frozen=True)
class Judged:
    """A scan: its verdict, and what its mesh's sigma is worth."""

    name: str
    kind: str
    verdict: str
    found: Coverage
    sigma_seconds: float
    seconds: float


def main() -> int:
    """Make, scan, judge, print."""
    options = options_of(__doc__, "scans", 20).parse_args()
    series = Series("scan_{:02d}", partial(made, options.seed), judged, Table(HEAD, line, row, summary), BULKY)
    return series.run(range(options.scans), options)


def made(seed: int, k: int, folder: Path) -> None:
    """Scan k; generators take turns."""
    shutil.rmtree(folder, ignore_errors=True)
    kind, number = KINDS[k % len(KINDS)], k // len(KINDS)
    rng = np.random.default_rng([seed, k])
    if kind == "planted":
        planted_making.make(CLEAN[number % len(CLEAN)], 1000 * seed + number, folder)
    elif kind == "hard":
        hard_making.make(hard_drawing.drawn(folder.name, "", rng), folder, rng)
        _state(folder / "recording" / "camera.json", rng)
    else:
        principle, shape = ("itof", "structured_light")[number % 2], ("statue", "blocks")[number // 2 % 2]
        fresh_making.make(fresh_unit.drawn(principle, shape, folder.name, rng), folder, rng)
    (folder / "kind.json").write_text(json.dumps({"kind": kind}), encoding="utf-8")


def _state(file: Path, rng: np.random.Generator) -> None:
    """A focal length that is wrong by a draw, and says how well it is known."""
    camera = json.loads(file.read_text(encoding="utf-8"))
    factor = 1 + STD * float(np.clip(rng.standard_normal(), -2, 2))
    for lens in (camera, camera["color"]):
        lens |= {"fx": lens["fx"] * factor, "fy": lens["fy"] * factor}
    camera["std"] = {"fx": STD * camera["fx"], "fy": STD * camera["fy"], "cx": 0.5, "cy": 0.5}
    file.write_text(json.dumps(camera, indent=1), encoding="utf-8")


def judged(folder: Path) -> Judged:
    """A scan's folder, made before."""
    kind = json.loads((folder / "kind.json").read_text(encoding="utf-8"))["kind"]
    for name in ("result", "compare"):
        shutil.rmtree(folder / name, ignore_errors=True)
    recording, how = (_calibrated(folder)) if kind == "fresh" else (folder / "recording", [])
    ran = fusion("turntable", recording, *how, "-o", folder / "result", "--no-report")
    (folder / "terminal.txt").write_text(ran.terminal, encoding="utf-8")
    if ran.status:
        return Judged(folder.name, kind, "failed", Coverage(), np.nan, ran.seconds)
    true = next(file for name in ("truth.ply", "object.ply") if (file := folder / "truth" / name).is_file())
    mesh = folder / "result" / "mesh.ply"
    fusion("compare", mesh, true, "-o", folder / "compare", "--no-report")
    start = np.array(content(folder / "compare" / "comparison.json")["T_reference_mesh"])
    told = content(folder / "result" / "settings.json")
    spent = told.get("seconds", {})
    taken = float(spent.get("sigma", np.nan)) / max(sum(spent.values()), 1e-9) if spent else np.nan
    verdict = content(folder / "result" / "turntable.json")["verdict"]
    return Judged(folder.name, kind, verdict, coverage(mesh, true, start), taken, ran.seconds)


def _calibrated(folder: Path) -> tuple[Path, list[object]]:
    """A unit's scan, and the options that its owner's calibration gives."""
    camera, sensor = folder / "intrinsics" / "camera.json", folder / "depth" / "sensor.json"
    board = ["--board", folder / "board.json"]
    if not camera.is_file():
        fusion("calibrate", "intrinsics", folder / "board", *board, "-o", camera.parent, "--no-report")
    lens: list[object] = ["--camera", camera] if camera.is_file() else []
    if not sensor.is_file():
        known = ["--sensor", folder / "sensor.json", "--distance-std", 0.0007]
        surfaces = [*sorted(folder.glob("wall_*")), *([folder / "board", *board] if lens else [])]
        fusion("calibrate", "depth", *surfaces, *lens, *known, "-o", sensor.parent, "--no-report")
    return folder / "scan", [*lens, "--sensor", sensor if sensor.is_file() else folder / "sensor.json"]


COLUMNS = ("in 90 %", "in 68 %", "> 3 s", "error mm", "sigma mm", "order")
HEAD = f"{'scan':<9}{'generator':<11}{'verdict':<10}" + "".join(f"{name:>9}" for name in COLUMNS)


def line(one: Judged) -> str:
    """One scan."""
    c = one.found
    return (
        f"{one.name:<9}{one.kind:<11}{one.verdict:<10}{c.ninety:>9.3f}{c.one:>9.3f}{c.far:>9.3f}"
        f"{1e3 * c.rms:>9.2f}{1e3 * c.claimed:>9.2f}{c.order:>9.2f}"
    )


def summary(scans: Sequence[Judged]) -> str:
    """All surface together, every scan counting alike."""
    some = [s for s in scans if np.isfinite(s.found.ninety)]
    rows = []
    for kind in ("all", *KINDS):
        ours = [s.found for s in some if kind in ("all", s.kind)]
        if ours:
            ninety, one, far = (np.mean([getattr(c, name) for c in ours]) for name in ("ninety", "one", "far"))
            inside = sum(LOW <= c.ninety <= HIGH for c in ours)
            rows.append(
                f"{kind:<9}{len(ours):>3} scans: {ninety:.1%} of the surface within the 90 % interval, "
                f"{one:.1%} within one sigma, {far:.2%} beyond three; "
                f"{inside} single scans between {LOW:.0%} and {HIGH:.0%}"
            )
    rows.append(f"no mesh handed out: {len(scans) - len(some)}")
    taken = [s.sigma_seconds for s in some if np.isfinite(s.sigma_seconds)]
    return "\n".join([*rows, *([f"sigma took {np.median(taken):.1%} of a scan's time (median)"] if taken else [])])


def row(one: Judged) -> dict[str, Any]:
    """For JSON; NaN becomes null."""
    told = asdict(one) | asdict(one.found)
    told.pop("found")
    return {k: None if isinstance(x, float) and not np.isfinite(x) else x for k, x in told.items()}


if __name__ == "__main__":
    raise SystemExit(main())
