"""Runs contestants in turn, several rounds, each in a process of its own, and gathers what they answer."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from tools.benchmarks.stages.environments import CLOUDCOMPARE, GICP, IGL, OPEN3D, OPENCV, VDB, Needs, interpreter

PROGRAMS = Path(__file__).parent / "programs"
OURS = "fusion"


@dataclass(frozen=True)
class Contestant:
    """A program that does the work of some stages; of ours, `kernels` is what FUSION_KERNELS says."""

    name: str
    program: str
    stages: tuple[str, ...]
    needs: Needs | None = None
    kernels: str = ""


CONTESTANTS = (
    Contestant(OURS, "fusion_volume", ("integrate", "raycast", "extract", "error", "memory")),
    Contestant(
        "Open3D VoxelBlockGrid", "open3d_volume", ("integrate", "raycast", "extract", "error", "memory"), OPEN3D
    ),
    Contestant("OpenCV HashTSDF", "opencv_volume", ("integrate", "raycast"), OPENCV),
    Contestant("VDBFusion", "vdbfusion_volume", ("integrate", "extract"), VDB),
    Contestant(OURS, "fusion_align", ("align",)),
    Contestant("OpenCV odometry COMMON", "opencv_align", ("align",), OPENCV),
    Contestant("Open3D RGBD odometry", "open3d_align", ("align",), OPEN3D),
    Contestant("small_gicp PLANE_ICP", "small_gicp_align", ("align",), GICP),
    Contestant(OURS, "fusion_update", ("update",)),
    Contestant(OURS, "fusion_distances", ("distances",)),
    Contestant("Open3D unsigned", "open3d_distances", ("distances",), OPEN3D),
    Contestant("libigl signed", "libigl_distances", ("distances",), IGL),
    Contestant("CloudCompare signed", "cloudcompare_distances", ("distances",), CLOUDCOMPARE),
)


def beside(kernels: str) -> list[Contestant]:
    """Our programs on other kernels or another back end, as contestants beside the usual ones."""
    named = f"{OURS}, {kernels}"
    return [
        replace(c, name=named, kernels=kernels) for c in CONTESTANTS if c.name == OURS and "distances" not in c.stages
    ]


@dataclass
class Score:
    """What one contestant answered in all rounds; `arrays` is the file of the last one's arrays."""

    contestant: Contestant
    answers: list[dict[str, Any]] = field(default_factory=list)
    arrays: Path | None = None
    excuse: str = ""

    def times(self, stage: str) -> list[float]:
        """Median time of each round [ms]."""
        found = [a["times"].get(stage, []) for a in self.answers]
        return [float(np.median(t)) * 1e3 for t in found if t]

    def value(self, key: str) -> float | None:
        """Median over the rounds of a plain number."""
        found = [a[key] for a in self.answers if a.get(key) is not None]
        return float(np.median(found)) if found else None


def contest(chosen: list[Contestant], workload: Path, cache: Path, rounds: int) -> list[Score]:
    """Every contestant once a round, in an order that turns round by round."""
    scores = [Score(c) for c in chosen]
    pythons = {}
    for score in scores:
        python, score.excuse = (sys.executable, "")
        if score.contestant.needs:
            python, score.excuse = interpreter(score.contestant.needs, cache)
        pythons[id(score)] = python
    for n in range(rounds):
        able = [s for s in scores if not s.excuse]
        for score in able[:: 1 if n % 2 == 0 else -1]:
            names = (score.contestant.program, workload.stem, score.contestant.kernels)
            _run(score, pythons[id(score)], workload, cache / "-".join(filter(None, names)))
    return scores


def _run(score: Score, python: str, workload: Path, out: Path) -> None:
    program = PROGRAMS / f"{score.contestant.program}.py"
    command = [python, str(program), str(workload), str(out)]
    kernels = score.contestant.kernels
    environment = os.environ | ({"FUSION_KERNELS": kernels} if kernels else {})
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        score.excuse = (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1]
        return
    score.answers.append(json.loads(out.with_suffix(".json").read_text(encoding="utf-8")))
    arrays = out.with_suffix(".npz")
    score.arrays = arrays if arrays.exists() else None
