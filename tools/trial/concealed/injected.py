"""Real recordings with something concealed in them: a floor that a Kinect v2 on the ceiling saw, someone walking.

The floor's shape as this very sensor sees it is measured on every other frame and becomes the mesh; the other frames
are the case. Each is turned back into phasors, gets what is concealed, and is read out again: its noise, its drifts
and what the person leaves behind are real. Frames of this set are shifted as a whole by 14 mm rms (of unknown origin,
perhaps the way they were saved); that shift is taken away, and pixels that see the person are left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import binary_dilation, gaussian_filter, uniform_filter

from tools.trial.concealed.decks import Setting
from tools.trial.concealed.drawing import sign, sized
from tools.trial.concealed.laws import invented, named
from tools.trial.concealed.laws.flight import PER_METRE, Flight
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.plan import USUAL, Plan
from tools.trial.concealed.rays import Camera, Panel
from tools.trial.concealed.shot import Place, Shot

Array = NDArray[np.float64]

SOURCE = "data/kinect_v2_floor"
METRES = 4.5 / 65535  # per count; inferred by those who passed the set on
FOCAL = 366.0  # [px] usual for this camera: this unit's is not told
PERSON = 0.08  # [m] above the floor
LEAST = 20  # frames that a pixel must be seen in
GROUP = 7  # frames of a recording
DRAWN = ("column_delay", "emitter_parallax", "temperature_drift", "cyclic_error", "rings", "row_wave", "")


@dataclass(frozen=True)
class RealFlight(Flight):
    """A time-of-flight camera whose frames are real; `floor` is its noise at `reference` counts."""

    simulated: bool = False

    def sigma(self, shot: Shot) -> Array:
        return np.asarray(shot.kept["sigma"])

    def record(self, shot: Shot, laws: Sequence[Law], rng: np.random.Generator) -> tuple[Array, Array]:
        frames = []
        for i, z in enumerate(shot.kept["frames"]):
            r = z * shot.stretch
            place = Place(shot, i, shot.kept["amplitude"])
            delay = np.zeros(r.shape)
            for law in laws:
                if law.stage == "delay":
                    delay += law.share(place) * np.nan_to_num(law.acts(place))
            light = shot.kept["amplitude"] * np.exp(1j * PER_METRE[:, None, None] * (r + delay))
            read, _ = self.ranges(self.samples(light, place, laws), r)
            frames.append(np.where(z > 0, read / shot.stretch, 0.0))
        return np.array(frames), shot.kept["amplitude"]


def injected_plan(rng: np.random.Generator, shared: Path | None) -> Plan | None:
    """A case with real frames; None where the set is absent."""
    files = sorted((shared / SOURCE).glob("image*.png")) if shared else []
    if len(files) < 8 * GROUP:
        return None
    frames = _frames(files)
    shape, spread = _floor(frames[::2])
    device = RealFlight(shot=0.0, floor=float(np.nanmedian(spread)))
    shots = _shots(frames[1::2], shape, spread, device)
    name = str(rng.choice(DRAWN))
    laws = []
    if name:
        makers: dict[str, Any] = {**named.FLIGHT, **invented.FLIGHT}
        laws = [makers[name](rng)]
        laws = [sized(law, device, shots, rng.uniform(*USUAL) * sign(law, rng)) for law in laws]
    # the mean of 36 frames is not the floor: what is left of their noise
    setting = Setting("floor", True, bow_m=1e-3)
    return Plan("injected", setting, device, shots, laws, notes=name or "null")


def _frames(files: list[Path]) -> Array:
    """(n, h, w) depth [m] of every other pixel, NaN where nothing is or someone walks."""
    z = np.array([np.asarray(Image.open(p), float) for p in files])[:, ::2, ::2] * METRES
    z[z == 0] = np.nan
    seen = np.isfinite(z).sum(axis=0) >= LEAST
    usual = np.full(z.shape[1:], np.nan)
    usual[seen] = np.nanmedian(z[:, seen], axis=0)
    for i, one in enumerate(z):
        z[i] -= np.nanmedian(one - usual)
        away = np.abs(np.nan_to_num(z[i] - usual, nan=1.0)) > PERSON
        person = binary_dilation(uniform_filter(away.astype(float), 7) > 0.3, iterations=12)
        z[i][person | away] = np.nan
    return z


def _floor(frames: Array) -> tuple[Array, Array]:
    """(h, w) smooth shape [m] and spread of a frame [m]; NaN where too few frames see it."""
    seen = np.isfinite(frames).sum(axis=0) >= LEAST
    mean, spread = np.full(seen.shape, np.nan), np.full(seen.shape, np.nan)
    mean[seen], spread[seen] = np.nanmean(frames[:, seen], axis=0), np.nanstd(frames[:, seen], axis=0, ddof=1)
    return _smooth(mean, 2.0), _smooth(spread, 4.0)


def _smooth(image: Array, px: float) -> Array:
    known = np.isfinite(image).astype(float)
    out = gaussian_filter(np.nan_to_num(image), px) / np.maximum(gaussian_filter(known, px), 1e-3)
    return np.where(known > 0, out, np.nan)


def _shots(frames: Array, shape: Array, spread: Array, device: Flight) -> list[Shot]:
    h, w = shape.shape
    camera = Camera(w, h, FOCAL / 2, (w - 1) / 2, (h - 1) / 2)
    panels = [_plane(camera, shape)]
    start = Shot(camera, panels, np.eye(4), np.eye(4), np.zeros(1), np.zeros(1))
    # dark where it is noisy: with noise that is inverse to the light, that is what the light must have been
    amplitude = device.reference * device.floor / np.nan_to_num(spread * start.stretch, nan=np.inf)
    out = []
    for k in range(len(frames) // GROUP):
        times = 60.0 + 600.0 * k + np.arange(GROUP) / 15.0
        kept = {"frames": np.nan_to_num(frames[k * GROUP : (k + 1) * GROUP]), "mesh": _mesh(camera, shape)}
        kept |= {"sigma": np.nan_to_num(spread, nan=1.0), "amplitude": amplitude}
        temperatures = 24.0 + 16.0 * (1 - np.exp(-times / 900.0))
        out.append(replace(start, times=times, temperatures=temperatures, kept=kept))
    return out


def _plane(camera: Camera, shape: Array) -> Panel:
    """The plane through the floor, as large as the image sees of it."""
    good = np.isfinite(shape)
    points = camera.rays()[good] * shape[good][:, None]
    centre = points.mean(axis=0)
    x, y = np.linalg.svd(points[::7] - centre, full_matrices=False)[2][:2] * 3.0
    return Panel(centre - x - y, 2 * x, 2 * y, np.array([[0.5]]))


def _mesh(camera: Camera, shape: Array) -> str:
    """ASCII PLY of the floor at every second pixel."""
    points = (camera.rays() * shape[..., None])[::2, ::2]
    number = np.where(
        np.isfinite(points[..., 2]), np.cumsum(np.isfinite(points[..., 2])).reshape(points.shape[:2]) - 1, -1
    )
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    whole = (a >= 0) & (b >= 0) & (c >= 0) & (d >= 0)
    a, b, c, d = (corner[whole] for corner in (a, b, c, d))
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    vertices = points[np.isfinite(points[..., 2])]
    head = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    head += [f"property float {axis}" for axis in "xyz"] + [
        f"property uchar {name}" for name in ("red", "green", "blue")
    ]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    body = [f"{x:.6f} {y:.6f} {z:.6f} 128 128 128" for x, y, z in vertices]
    return "\n".join([*head, *body, *(f"3 {i} {j} {k}" for i, j, k in faces)]) + "\n"
