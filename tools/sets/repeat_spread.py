"""Is the repeatability that `fusion repeat` states the true one? Five simulated scans of each of some objects.

    python -m tools.sets.repeat_spread -o OUT --objects 4 --seed 1

An object, its table and camera are drawn by tools/sets/hard, which shares no code with the package, and recorded five
times with other noise. Each recording is scanned by `fusion turntable` and the results are given to `fusion repeat`.
The judge lays every mesh on the true object by a fit of its own, measures at points of the true surface how far outside
each mesh lies, and pools the variance between the meshes. `OUT/table.txt` holds what is printed.
"""

import os
import shutil
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.hard.drawing import drawn
from tools.sets.hard.making import make
from tools.sets.judging.command import fusion
from tools.sets.judging.coverage import fitted
from tools.sets.judging.said import content
from tools.sets.judging.series import Series, Table, options_of
from tools.sets.planted.measure import Surface

Array = NDArray[np.float64]
SCANS, POINTS = 5, 20_000
BESIDE, FAR = 1e-3, 5e-3  # [m] sideways or away: there the mesh ends, or shows something else
ASKED = 0.15  # of the true repeatability


@dataclass(frozen=True)
class Judged:
    """An object: repeatability standard deviations [m] as stated and true, and how many scans were handed out."""

    name: str
    story: str
    scans: int
    stated: float = np.nan
    true: float = np.nan

    @property
    def off(self) -> float:
        return self.stated / self.true - 1


def main() -> int:
    """Make, scan, judge, print."""
    options = options_of(__doc__, "objects", 4).parse_args()
    table = Table(f"{'object':<11}{'scans':>6}{'stated mm':>11}{'true mm':>9}{'off':>8}", line, row, summary)
    series = Series("object_{:02d}", partial(made, options.seed), judged, table, ("scan_*", "repeat"))
    return series.run(range(options.objects), options)


def made(seed: int, k: int, folder: Path) -> None:
    """Object k, recorded with other noise each time; those that steps of tens of degrees turn are drawn anew."""
    shutil.rmtree(folder, ignore_errors=True)
    for again in range(100):
        scan = drawn(folder.name, "", np.random.default_rng([seed, k, again]))
        if scan.story["largest step"] < 20 and scan.story["degrees"] > 350:
            break
    for i in range(SCANS):
        make(scan, folder / f"scan_{i}", np.random.default_rng([seed, k, again, i]))
    (folder / "story.txt").write_text(f"{scan.story['shape']} on {scan.story['base']}, {scan.story['camera']}")


def judged(folder: Path) -> Judged:
    """An object's folder, made before."""
    results = []
    for scan in sorted(folder.glob("scan_*")):
        shutil.rmtree(scan / "result", ignore_errors=True)
        fusion("turntable", scan / "recording", "-o", scan / "result", "--no-report", "--no-color")
        if (scan / "result" / "mesh.ply").is_file():
            results.append(scan)
    story = (folder / "story.txt").read_text(encoding="utf-8")
    if len(results) < 2:
        return Judged(folder.name, story, len(results))
    given = [scan / "result" for scan in results]
    fusion("repeat", *given, "-o", folder / "repeat", "--no-report", "--overwrite")
    stated = content(folder / "repeat" / "repeat.json")["repeatability"]["s_r_m"]
    return Judged(folder.name, story, len(results), float(stated), true_spread(results))


def true_spread(scans: list[Path]) -> float:
    """Standard deviation [m] between meshes, each laid on the true object, pooled over its surface."""
    true: Any = trimesh.load(scans[0] / "truth" / "truth.ply", process=False)
    points, face = trimesh.sample.sample_surface(true, POINTS, seed=0)
    normals, columns = np.asarray(true.face_normals)[face], []
    for scan in scans:
        mesh: Any = trimesh.load(scan / "result" / "mesh.ply", process=False)
        T = fitted(Surface(true), np.asarray(mesh.vertices, float), start(scan))
        mesh.apply_transform(T)
        away = Surface(mesh).nearest(np.asarray(points))[0] - points
        outside = (away * normals).sum(axis=1)
        sideways = np.linalg.norm(away - outside[:, None] * normals, axis=1)
        columns.append(np.where((sideways < BESIDE) & (np.abs(outside) < FAR), outside, np.nan))
    offsets = np.column_stack(columns)
    offsets = offsets[np.isfinite(offsets).all(axis=1)]
    return float(np.sqrt(offsets.var(axis=1, ddof=1).mean()))


def start(scan: Path) -> Array:
    """(4, 4) where a frame's pose puts the mesh."""
    true, own = (np.loadtxt(f) for f in (scan / "truth" / "poses.txt", scan / "result" / "trajectory.txt"))
    k = int(np.argmin(np.abs(true[:, 0] - own[0, 0])))
    return np.asarray(_pose(true[k]) @ np.linalg.inv(_pose(own[0])))


def _pose(row: Array) -> Array:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_quat(row[4:8]).as_matrix(), row[1:4]
    return T


def line(one: Judged) -> str:
    """One object."""
    numbers = f"{1e3 * one.stated:>11.3f}{1e3 * one.true:>9.3f}{one.off:>+8.1%}"
    return f"{one.name:<11}{one.scans:>6}{numbers}  {one.story}"


def summary(objects: list[Judged]) -> str:
    """How many are within what is asked."""
    known = [o for o in objects if np.isfinite(o.off)]
    return f"{sum(abs(o.off) <= ASKED for o in known)} of {len(known)} objects within {ASKED:.0%} of the true spread"


def row(one: Judged) -> dict[str, Any]:
    """For JSON; NaN becomes null."""
    told = asdict(one) | {"off": one.off}
    return {k: None if isinstance(x, float) and not np.isfinite(x) else x for k, x in told.items()}


if __name__ == "__main__":
    raise SystemExit(main())
