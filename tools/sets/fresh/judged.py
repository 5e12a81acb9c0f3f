"""Runs the chain of commands over a unit as its owner would, and measures what comes of it."""

import json
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sets.fresh.information import Allowed, allowed
from tools.sets.judging.command import Ran, fusion
from tools.sets.judging.measured import Fit, angle_errors, compared, offset, own_fit
from tools.sets.judging.said import Said, content, read

Array = NDArray[np.float64]

NAMES_SCALE = r"\bscale\b|\bsize\b|(?<!no )\bdepth\b|focal"  # "gives no depth" is told of holes
ASKED, WORST = 0.002, 0.005  # of the scale
ANGLE, RATIO = 0.15, 1.15  # [deg] rms; std over that of true poses


@dataclass(frozen=True)
class Judged:
    """A unit. Scale errors are relative, `std` in metres, NaN where there is no number.

    Attributes:
        scale: by `fusion compare --scale`; `again`: by the judge's own fit.
        angle: rms [deg] after the best constant; `moved`: without the frames' median, the largest.
        floor: scale of true poses and true depth, by the judge's fit: what resolution and volume do.
        raw: [m] what is wrong with the depth of the object as measured, its median; below zero it is too far.
        bias: [m] what the unit's own calibration leaves in the depth of the object: its surface at true poses, beside
            that of true depth; below zero it is too far. Over the distance this is what a scan must get wrong.
        focal: fx calibrated over the true one, minus 1.
        known: what the scan says of its size, one standard deviation.
        ratio: std of the scan over that of true poses and true depth.
    """

    name: str
    kind: str
    shape: str
    said: Said
    allowed: Allowed
    scale: float = np.nan
    again: float = np.nan
    floor: float = np.nan
    raw: float = np.nan
    bias: float = np.nan
    angle: float = np.nan
    largest: float = np.nan
    rejected: int = 0
    focal: float = np.nan
    std: float = np.nan
    std_true: float = np.nan
    law: str = ""
    status: dict[str, int] = field(default_factory=dict)
    seconds: float = 0.0
    known: float = np.nan

    @property
    def ratio(self) -> float:
        return self.std / self.std_true

    @property
    def limit(self) -> float:
        """The scale error that is asked: 0.2 %, or twice what walls and boards allow."""
        return max(ASKED, 2 * self.allowed.scale)

    @property
    def within(self) -> bool:
        return bool(abs(self.scale) <= self.limit)

    @property
    def beyond(self) -> float:
        """What the scan adds to the scale error of true poses and true depth: windows flatten what bulges."""
        return self.again - self.floor

    @property
    def told(self) -> bool:
        """Doubtful, failed, or a warning that speaks of scale or depth."""
        return self.said.verdict != "good" or self.said.names(NAMES_SCALE)

    @property
    def unsaid(self) -> bool:
        """A scale that is off by more than half a percent, or none at all, and nothing says so."""
        return not abs(self.scale) <= WORST and not self.told


def judged(folder: Path) -> Judged:
    """A unit's folder, made before."""
    truth = json.loads((folder / "truth" / "truth.json").read_text(encoding="utf-8"))
    runs = chain(folder)
    said = read(folder / "result", runs["turntable"])
    true, seen = folder / "truth" / "truth.ply", folder / "truth" / "visible.npz"
    mesh, table = folder / "result" / "mesh.ply", content(folder / "result" / "turntable.json")
    free = compared(mesh, true, folder / "compare_scale", seen, scale=True)
    own = own_fit(mesh, true, start(folder)) if free else Fit(np.nan, np.nan)
    ideal, bias = _at_true_poses(folder)
    errors = angle_errors(table, np.array(truth["angles_rad"], float))
    errors = errors - np.nanmean(errors) if np.isfinite(errors).any() else errors
    camera = content(folder / "intrinsics" / "camera.json")
    nothing = np.nan
    return Judged(
        folder.name, truth["sensor"], truth["object"], said, allowed(folder, truth),
        free.scale - 1 if free else nothing, own.scale - 1,
        ideal.scale - 1, raw_bias(folder), bias,
        float(np.sqrt(np.nanmean(errors**2))) if np.isfinite(errors).any() else nothing,
        float(np.nanmax(np.abs(errors))) if np.isfinite(errors).any() else nothing,
        int(np.isnan(errors).sum()), camera.get("fx", nothing) / truth["camera"]["fx"] - 1,
        own.std, ideal.std, _law(folder),
        {name: ran.status for name, ran in runs.items()}, sum(ran.seconds for ran in runs.values()),
        _known(folder / "result"),
    )  # fmt: skip


def _known(result: Path) -> float:
    told = content(result / "settings.json").get("sigma") or {}
    return float((told.get("common") or {}).get("scale_relative") or np.nan)


def chain(folder: Path) -> dict[str, Ran]:
    """Intrinsics, depth, the scan; and at true poses the scan without errors, and as the unit's calibration has it."""
    for name in ("intrinsics", "depth", "result", "posed", "posed_own"):
        shutil.rmtree(folder / name, ignore_errors=True)
    walls = sorted(folder.glob("wall_*"))
    camera, sensor = folder / "intrinsics" / "camera.json", folder / "depth" / "sensor.json"
    out = {}
    board = ["--board", folder / "board.json"]
    out["intrinsics"] = fusion("calibrate", "intrinsics", folder / "board", *board, "-o", camera.parent, "--no-report")
    lens = ["--camera", camera] if camera.is_file() else []
    known = ["--sensor", folder / "sensor.json", "--distance-std", 0.0007]
    surfaces = [*walls, folder / "board", *board] if lens else walls
    out["depth"] = fusion("calibrate", "depth", *surfaces, *lens, *known, "-o", sensor.parent, "--no-report")
    model = ["--sensor", sensor if sensor.is_file() else folder / "sensor.json"]
    out["turntable"] = fusion("turntable", folder / "scan", *lens, *model, "-o", folder / "result", "--no-report")
    poses = ["--poses", folder / "truth" / "poses.txt", "--object", "--force", "--no-report"]
    noise = ["--sensor", folder / "sensor.json"]
    out["posed"] = fusion("reconstruct", folder / "clean", *poses, *noise, "-o", folder / "posed")
    out["own"] = fusion("reconstruct", measured(folder), *poses, *lens, *model, "-o", folder / "posed_own")
    for name, ran in out.items():
        (folder / f"{name}.txt").write_text(ran.terminal, encoding="utf-8")
    return out


def measured(folder: Path) -> Path:
    """The scan with its errors, the object alone: where the one without errors has depth."""
    out = folder / "measured"
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(folder / "clean", out)
    shutil.copy(folder / "scan" / "camera.json", out)
    for file in (out / "depth").iterdir():
        mask = np.asarray(cv2.imread(str(file), cv2.IMREAD_UNCHANGED)) > 0
        depth = np.asarray(cv2.imread(str(folder / "scan" / "depth" / file.name), cv2.IMREAD_UNCHANGED))
        if not cv2.imwrite(str(file), np.where(mask, depth, 0).astype(np.uint16)):
            raise OSError(f"{file}: not written")
    return out


def raw_bias(folder: Path) -> float:
    """Median [m] over every fifth frame of the depth without errors less that of the scan, on the object."""
    scale, apart = content(folder / "clean" / "camera.json")["depth_scale"], []
    for file in sorted((folder / "clean" / "depth").iterdir())[::5]:
        names = file, folder / "scan" / "depth" / file.name
        true, own = (np.asarray(cv2.imread(str(name), cv2.IMREAD_UNCHANGED), float) for name in names)
        both = (true > 0) & (own > 0)
        apart.append((true - own)[both] / scale)
    return float(np.median(np.concatenate(apart)))


def start(folder: Path) -> Array:
    """(4, 4) where the first frame's pose puts the mesh of the scan."""
    first = [np.loadtxt(file)[0] for file in (folder / "truth" / "poses.txt", folder / "result" / "trajectory.txt")]
    T_true, T_own = (_pose(row) for row in first)
    return np.asarray(T_true @ np.linalg.inv(T_own))


def _at_true_poses(folder: Path) -> tuple[Fit, float]:
    """The mesh of true poses and true depth, and `bias`."""
    true, ideal, own = (folder / name for name in ("truth/truth.ply", "posed/mesh.ply", "posed_own/mesh.ply"))
    if not (ideal.is_file() and own.is_file()):
        return Fit(np.nan, np.nan), np.nan
    return own_fit(ideal, true, np.eye(4)), offset(own, true) - offset(ideal, true)


def _pose(row: Array) -> Array:
    from scipy.spatial.transform import Rotation

    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_quat(row[4:8]).as_matrix(), row[1:4]
    return T


def _law(folder: Path) -> str:
    """Effects that the calibration wrote and the owner's sensor.json had not."""

    def effects(file: Path) -> list[Any]:
        return [x["effect"] for x in content(file).get("effects", [])]

    had = effects(folder / "sensor.json")
    return " ".join(x for x in effects(folder / "depth" / "sensor.json") if x not in had)
