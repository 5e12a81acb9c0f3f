"""Scans made ready to print: are they solid, and how far off is what was closed?

    python -m tools.sets.passes -o OUT --seed 411 --keep      two passes of 18 objects, kept
    python -m tools.sets.closed OUT                           the first pass of each, closed; `--merged`: both passes

`fusion convert MESH closed.ply --watertight` runs as a user runs it. manifold3d, which slicers use, says whether it is
a solid. The mesh is laid on the truth by what was seen alone; then the rms distance of the part that was seen, and of
the part that was closed, to the true surface. Asked: all solid, and the closed part less than twice as far off as the
seen one. `foot`: the same of what was closed at the open bottom, `bare`: elsewhere; `plate`: where the true object's
lowest point lies in the scan's frame, whose z = 0 is the plate as the scan found it.
"""

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tools.sets.judging.command import fusion
from tools.sets.planted.measure import Surface
from tools.sets.two_passes.judged import scan_of

Array = NDArray[np.float64]
BOUND = 2.0  # of the rms of what was seen
SAMPLES = 40_000
FOOT = 0.012  # [m] above the plate


@dataclass(frozen=True)
class Closed:
    """One mesh; lengths in mm, NaN where nothing was closed there."""

    name: str
    what: str
    solid: bool
    seen: float
    closed: float
    foot: float
    bare: float
    share: float
    plate: float

    @property
    def right(self) -> bool:
        return self.solid and not self.closed > BOUND * self.seen

    def line(self) -> str:
        return (
            f"{self.name:<9}{'yes' if self.right else 'NO':<7}{self.seen:>7.2f}{self.closed:>8.2f}"
            f"{self.closed / self.seen:>7.2f}{self.foot:>7.2f}{self.bare:>7.2f}{100 * self.share:>8.1f}"
            f"{self.plate:>8.2f}{'  solid ' if self.solid else '  OPEN  '} {self.what}"
        )


HEAD = (
    f"{'pair':<9}{'right':<7}{'seen':>7}{'closed':>8}{'ratio':>7}{'foot':>7}{'bare':>7}{'share %':>8}{'plate':>8}  [mm]"
)


def main() -> int:
    """Close, judge, print; exit status 1 where one is not right."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("made", type=Path, help="a folder of tools.sets.passes, kept")
    parser.add_argument("--merged", action="store_true", help="what both passes became")
    options = parser.parse_args()
    scan = "merged" if options.merged else "scan_1"
    print(HEAD, flush=True)
    cases = []
    for folder in sorted(options.made.glob("pair_*")):
        if (folder / scan / "mesh.ply").is_file():
            cases.append(judged(folder, folder / scan / "mesh.ply"))
            print(cases[-1].line(), flush=True)
    right = sum(case.right for case in cases)
    print(f"solid: {sum(case.solid for case in cases)}, right: {right} of {len(cases)}")
    (options.made / f"closed_{scan}.json").write_text(json.dumps([asdict(c) for c in cases], indent=1), "utf-8")
    return int(right < len(cases))


def judged(folder: Path, scan: Path) -> Closed:
    """Close one mesh, lay it on the truth, measure both parts."""
    truth = json.loads((folder / "truth" / "truth.json").read_text(encoding="utf-8"))
    true: Any = trimesh.load(folder / "truth" / "object.ply", process=False)
    out = folder / f"closed_{scan.parent.name}.ply"
    ran = fusion("convert", scan, out, "--watertight", "--overwrite")
    if ran.status:
        raise SystemExit(f"{folder.name}: {ran.last}")
    mesh: Any = trimesh.load(out, process=False)
    closed = np.asarray(mesh.metadata["_ply_raw"]["vertex"]["data"]["scalar_closed"]).ravel() == 1
    sampled, face = trimesh.sample.sample_surface(mesh, SAMPLES, seed=0)
    points = np.asarray(sampled, float)
    guessed = closed[np.asarray(mesh.faces)[np.asarray(face)]].sum(axis=1) >= 2
    T = np.asarray(np.linalg.inv(scan_of(folder, 1)), float)
    laid, off = fitted(points, ~guessed, T, Surface(true))
    low = (np.linalg.inv(laid) @ np.append(_lowest(true, laid), 1))[2]
    foot = guessed & (points[:, 2] < points[:, 2].min() + FOOT)
    seen, all_, feet, bare = (_rms(off[part]) for part in (~guessed, guessed, foot, guessed & ~foot))
    what = f"{truth['shape']}, {truth['camera']}"
    share = float(guessed.mean())
    return Closed(folder.name, what, solid(mesh), seen, all_, feet, bare, share, 1e3 * float(low))


def _lowest(true: Any, laid: Array) -> Array:
    """The true surface's lowest point (3,) as the scan stands."""
    there = np.asarray(true.vertices)
    return np.asarray(there[((there - laid[:3, 3]) @ laid[:3, :3])[:, 2].argmin()])


def fitted(points: Array, seen: NDArray[np.bool_], T: Array, surface: Surface) -> tuple[Array, Array]:
    """`T_true_scan` (4, 4) that lays what was seen onto the truth, and how far points (n, 3) then are off (n,) [m]."""
    for _ in range(30):
        moved = points @ T[:3, :3].T + T[:3, 3]
        nearest, normal = surface.nearest(moved)
        off = ((nearest - moved) * normal).sum(axis=1)
        use = seen & (np.abs(off) < 0.01)
        x = np.linalg.lstsq(np.hstack([np.cross(moved[use], normal[use]), normal[use]]), off[use], rcond=None)[0]
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = Rotation.from_rotvec(x[:3]).as_matrix(), x[3:]
        T = step @ T
        if np.abs(x).max() < 1e-7:
            break
    moved = points @ T[:3, :3].T + T[:3, 3]
    return T, np.linalg.norm(moved - surface.nearest(moved)[0], axis=1)


def solid(mesh: Any) -> bool:
    """manifold3d takes it as a solid."""
    import manifold3d

    faces, vertices = np.asarray(mesh.faces, np.uint32), np.asarray(mesh.vertices, np.float32)
    made = manifold3d.Manifold(manifold3d.Mesh(vert_properties=vertices, tri_verts=faces))
    return bool(made.status() == manifold3d.Error.NoError and made.volume() > 0)


def _rms(off: Array) -> float:
    return 1e3 * float(np.sqrt(np.mean(off**2))) if len(off) else float("nan")


if __name__ == "__main__":
    raise SystemExit(main())
