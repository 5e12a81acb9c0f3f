"""What the bench found, and one sentence that says it."""

from dataclasses import dataclass, field

import numpy as np
from scipy.special import gammaincinv

from fusion.calibration.noise.ambient import AmbientEstimate
from fusion.evaluation.near_limit import NearLimit
from fusion.evaluation.notes import Note
from fusion.evaluation.quantization import Quantization
from fusion.evaluation.still.shares import Shares
from fusion.evaluation.stretch_look import StretchLook
from fusion.geometry.camera import Camera
from fusion.sensor.sensor import Sensor

STILL = 5  # frames of one view: fewer tell no noise


@dataclass(frozen=True)
class Evaluation:
    """The bench's findings."""

    camera: Camera  # that made the recordings
    looks: list[StretchLook]  # one per still stretch
    shares: dict[str, Shares]  # over depth, incidence and brightness, as far as each is known
    near: list[NearLimit]  # shortest usable distances
    quantization: Quantization | None  # over all stretches
    ambient: AmbientEstimate | None  # light estimated from the noise; None where it cannot be
    notes: list[Note] = field(default_factory=list)  # what a reader should know
    sensor: Sensor | None = None  # the model compared with

    def __repr__(self) -> str:
        return f"<Evaluation: {summary(self)}>"

    @property
    def longest(self) -> StretchLook:
        """The stretch that lasted longest: the one that can tell of drift."""
        return max(self.looks, key=lambda look: float(look.still.time[-1]))


def summary(found: Evaluation) -> str:
    """The finding in one sentence, from the most asked: offset, noise, valid share, warm or not."""
    looks = found.looks
    frames = sum(look.still.frames for look in looks)
    places = f"{len(looks)} views, " if len(looks) > 1 else ""
    unsteady = sum(look.still.frames for look in looks if look.shared.changes or _between_moves(look))
    if frames > STILL and unsteady > frames / 2:
        return f"{places}{frames} frames: nothing stands still, so nothing is told about the camera."
    parts = [part for part in (_offset(found), _noise(found), _valid(found)) if part]
    verdict, bias = found.longest.drift.verdict, found.longest.bias
    warm = {"ready": "the camera is warm", "not warmed up": "the camera is not warm yet"}.get(
        verdict, "too short to say whether it is warm"
    )
    if bias is not None and bias.beside:
        warm = "what is in the image's middle is no part of the surface"
    return f"{places}{frames} frame{'s' if frames > 1 else ''}: {'; '.join([*parts, warm])}."


def _between_moves(look: StretchLook) -> bool:
    """Whether it is one of the pieces of a recording that stands still for a few frames at most."""
    return look.still.frames < STILL and not look.stretch.alone


def _offset(found: Evaluation) -> str:
    known = [look.bias for look in found.looks if look.bias is not None and np.isfinite(look.bias.offset)]
    if not known:
        return ""
    off = np.array([bias.offset for bias in known]) * 1e3
    if len(known) == 1:
        return f"depth off by {off[0]:+.1f} mm at {known[0].distance:.2f} m"
    return (
        f"depth off by {np.min(off):+.1f} to {np.max(off):+.1f} mm between {_range([bias.distance for bias in known])}"
    )


def _noise(found: Evaluation) -> str:
    known = [(look.surface.distance, _axial(look)) for look in found.looks
             if (np.isfinite(look.still.depth.std) & (look.still.depth.std > 0)).any()]  # fmt: skip
    if not known:
        return ""
    sigma = np.array([s for _, s in known]) * 1e3
    if len(known) == 1:
        return f"noise {sigma[0]:.1f} mm at {known[0][0]:.2f} m"
    return f"noise {np.min(sigma):.1f} to {np.max(sigma):.1f} mm"


def _axial(look: StretchLook) -> float:
    """Noise [m] at the surface's distance, as the target tells it; without one, of a pixel as it is typical.

    Where depths lie far apart, it is that of all the surface's pixels, at whatever place between two depths they are.
    """
    if look.coarse:
        seen = look.still.depth.std[look.surface.region]
        return float(np.sqrt(np.nanmean(seen**2)))
    axial = np.nan if look.noise is None else look.noise.axial
    return axial if np.isfinite(axial) else _typical(look)


def _typical(look: StretchLook) -> float:
    """Noise [m] of a pixel in the middle: a standard deviation of few frames is mostly too small (chi's median)."""
    free = max(look.still.frames - 1, 1)
    return float(np.nanmedian(look.still.depth.std) / np.sqrt(2 * gammaincinv(free / 2, 0.5) / free))


def _valid(found: Evaluation) -> str:
    counts = np.array(
        [[t.valid.sum(), t.missing.sum(), t.outliers.sum()] for t in (look.tiles for look in found.looks)]
    )
    total = counts.sum()
    if not total:
        return ""
    valid, _, outliers = 100 * counts.sum(axis=0) / total
    return f"{valid:.1f} % of the values valid, {outliers:.2f} % outliers"


def _range(values: list[float]) -> str:
    return f"{min(values):.2f} and {max(values):.2f} m"
