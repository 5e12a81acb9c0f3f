"""A drawn scan becomes a recording, the same with all but the object masked away at its true poses, and the truth."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.sets.hard.cameras import picture, taken
from tools.sets.hard.drawing import Drawn
from tools.sets.hard.stage import OBJECT
from tools.sets.judging.writing import Recording, plain, trajectory

Array = NDArray[np.float64]

COUNTS = 1000  # per metre
SEEN = 400  # surface points kept of each frame
EVERY = 0.4  # [s] between frames


def make(scan: Drawn, folder: Path, rng: np.random.Generator) -> None:
    """An older scan of the same name is made anew."""
    shutil.rmtree(folder, ignore_errors=True)
    truth = folder / "truth"
    truth.mkdir(parents=True)
    lens = _camera(scan)
    recording = Recording(folder / "recording", lens | {"depth_scale": COUNTS * scan.unit})
    recording.camera["color"] = {k: lens[k] for k in ("width", "height", "fx", "fy", "cx", "cy", "distortion")} | {
        "T_color_depth": np.eye(4).tolist()
    }
    masked = Recording(folder / "masked", lens | {"depth_scale": COUNTS})
    times, seen = 50 + EVERY * np.arange(len(scan.turning.degrees)), []
    for i, time in enumerate(times):
        frame = scan.stage.frame(i)
        counts = np.rint(taken(scan.device, frame, rng) * COUNTS) / COUNTS
        recording.depth(time, counts / scan.unit)  # the files hold what they hold: only what is stated of them is wrong
        recording.rgb(time, picture(frame.colour, scan.exposure[i], rng))
        masked.depth(time, np.where(frame.part == OBJECT, counts, 0.0))
        at = np.argwhere(frame.part == OBJECT)
        v, u = rng.permutation(at)[:SEEN].T
        T = np.linalg.inv(scan.T_world_item[i]) @ scan.stage.T_world_camera[i]
        points = frame.z[v, u, None] * scan.stage.camera.rays[v, u]
        seen.append(points @ T[:3, :3].T + T[:3, 3])
    logged = scan.turning.logged
    recording.done(**({} if logged is None else {"turntable_deg": logged}))
    masked.done()
    poses = np.linalg.inv(scan.T_world_item) @ scan.stage.T_world_camera
    trajectory(truth / "poses.txt", times, poses)
    scan.item.export(truth / "truth.ply")
    np.savez(truth / "visible.npz", points=np.concatenate(seen).astype(np.float32))
    told = {"planted": scan.planted, "angles_rad": np.deg2rad(scan.turning.degrees), "story": scan.story}
    text = json.dumps({name: plain(x) for name, x in told.items()}, indent=1)
    (truth / "truth.json").write_text(text, encoding="utf-8")


def _camera(scan: Drawn) -> dict[str, Any]:
    """camera.json; the focal length is right, and nothing is stated of how well it is known."""
    c = scan.device.camera
    lens: dict[str, Any] = {"width": c.width, "height": c.height, "fx": c.f, "fy": c.f, "cx": c.cx, "cy": c.cy}
    return lens | {"distortion": [0.0] * 5, "principle": scan.device.principle, "sensor": scan.story["camera"]}
