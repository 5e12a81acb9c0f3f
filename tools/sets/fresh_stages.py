"""Where a fresh unit's scale error comes from: the truth is put in one thing after the other, each line on the last.

    python -m tools.sets.fresh_units -o OUT --units 6 --seed 443 --keep
    python -m tools.sets.fresh_stages OUT --seed 443 --only 1 3 5

The frames show the object alone and are fused in voxels as the scan's own. Printed is `scale` of `fusion compare` [%]
as fused, and once more without what windows and the volume mix (`fusion/volume/unmixed.py`):

    scan        the mesh of the scan           own       own poses, camera, depth: what segmentation and cleaning do
    poses       true poses                     lens      the true camera, and no errors that the scan itself found
    law         without the errors of depth that calibration is for; noise, windows, edges as before
    noise       without noise                  exact     true depth at the pixels' centres, of the same pixels
    whole       of all pixels of the object: what is left is the volume's and the comparison's
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.alignment.align import align_meshes
from fusion.mesh.cleanup import large_parts
from fusion.mesh.files import read_mesh
from fusion.mesh.mesh import Mesh
from fusion.passes.from_result import taken_out_of
from fusion.recording.native.trajectory_file import read_trajectory
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.scan.finding.relieved import relieved
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.files.sensor_file import read_sensor
from fusion.volume.prepared import Prepared, fused, prepare
from fusion.volume.unmixed import matching_window, unmixed
from fusion.volume.volume import VolumeSettings
from tools.sets.fresh.judged import start
from tools.sets.fresh.unit import Unit, drawn
from tools.sets.fresh.views import OBJECT
from tools.sets.fresh_units import KINDS, SHAPES
from tools.sets.judging.said import content

Array = NDArray[np.float64]
NAMES = ("scan", "own", "poses", "lens", "law", "noise", "exact", "whole")


def main() -> int:
    """Print a line of each unit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--only", type=int, nargs="+", required=True, metavar="K")
    options = parser.parse_args()
    print(f"{'unit':<9}" + "".join(f"{name:>16}" for name in NAMES), flush=True)
    for k in options.only:
        folder = options.output / f"unit_{k:02d}"
        unit = drawn(KINDS[k % 2], SHAPES[k // 2 % 2], folder.name, np.random.default_rng([options.seed, k]))
        print(f"{folder.name:<9}" + "".join(f"{text:>16}" for text in told(folder, unit)), flush=True)
    return 0


def told(folder: Path, unit: Unit) -> Iterator[str]:
    """Each stage's scale error in percent, as fused and unmixed."""
    truth, seen = read_mesh(folder / "truth" / "truth.ply"), np.load(folder / "truth" / "visible.npz")["points"]

    def scale(mesh: Mesh) -> float:
        return 100 / align_meshes(mesh, truth, scale=True, seen=seen.astype(float)).scale - 100

    yield f"{scale(read_mesh(folder / 'result' / 'mesh.ply')):.2f}"
    chosen = content(folder / "result" / "settings.json")
    low, high = truth.vertices.min(axis=0) - 0.03, truth.vertices.max(axis=0) + 0.03
    bounds = tuple(map(float, low)), tuple(map(float, high))
    settings = VolumeSettings(chosen["voxel_m"], chosen["truncation_m"], bounds=bounds)  # type: ignore[arg-type]
    window = matching_window(read_sensor(folder / "depth" / "sensor.json"), unit.device.lens.fx)
    for frames, poses in stages(folder, unit):
        first = fused(settings, frames, poses)
        again = fused(settings, unmixed(frames, first, poses, window), poses)
        both = (scale(large_parts(one.surface(), 1.0)[0]) for one in (first, again))
        yield " ".join(f"{x:6.2f}" for x in both)


def stages(folder: Path, unit: Unit) -> Iterator[tuple[list[Prepared | None], Array]]:
    """The frames and their poses, stage by stage."""
    sensor = read_sensor(folder / "depth" / "sensor.json")
    own = open_recording(folder / "measured", folder / "intrinsics" / "camera.json")
    right, clean = open_recording(folder / "measured"), open_recording(folder / "clean")
    corrected = list(corrected_recording(own, sensor)[0])
    true, placed = unit.poses(), start(folder) @ read_trajectory(folder / "result" / "trajectory.txt").poses
    calibrated: list[Prepared | None] = [prepare(f, own.camera, sensor) for f in corrected]
    check = taken_out_of(content(folder / "result" / "turntable.json")["depth_taken_out"], own)
    yield relieved(calibrated, check), placed
    yield relieved(calibrated, check), true
    lens = clean.camera
    yield [prepare(f, lens, sensor) for f in corrected_recording(replace(right, camera=lens), sensor)[0]], true
    both = list(zip(clean, corrected, strict=True))
    law = [_as(f, np.where(np.isfinite(g.depth), f.depth, np.nan)) for f, g in both]
    yield [prepare(f, lens, sensor) for f in law], true
    rays, middle, rng = unit.device.lens.four(), unit.device.lens.rays(), np.random.default_rng(0)
    names = ("grain", "dark") if unit.device.principle == "itof" else ("speckle", "noise")
    quiet = replace(unit.device, **dict.fromkeys(names, 0.0))  # type: ignore[arg-type]
    still, exact, whole = [], [], []
    for f, T in zip(law, true, strict=True):
        scene = unit.table.at(T)
        view, there = scene.look(middle), np.isfinite(f.depth)
        z = np.where(view.part == OBJECT, view.z, np.nan)
        still.append(_as(f, np.where(there, quiet.frames(scene, 1, rng, rays, ideal=True)[0][0], np.nan)))
        exact.append(_as(f, np.where(there, z, np.nan)))
        whole.append(_as(f, z))
    for frames in (still, exact, whole):
        yield [prepare(f, lens, sensor) for f in frames], true


def _as(frame: Frame, depth: Array) -> Frame:
    return replace(frame, depth=np.where(depth > 0, depth, np.nan).astype(np.float32))


if __name__ == "__main__":
    raise SystemExit(main())
