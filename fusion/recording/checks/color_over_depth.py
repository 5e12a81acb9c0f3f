"""Does colour lie over depth? Cameras give both side by side; only what was registered lies over each other.

Where a thing ends in depth, its colour ends as well. So the rims of depth lie over edges of colour, and where they do
not, colour that is moved and scaled as another camera's would be may show where it came from.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

# a rim: the next pixel is farther by this share, and by so many times more than the surface falls on either side
STEP, STEEPER = 0.05, 4.0
RIMS = 50  # pixels a frame must show
ACROSS, DOWN = 0.1, 0.04  # of the width: cameras stand side by side
# of the width: registered colour lay within a quarter of it in twelve recordings of seven cameras, and within three
# quarters in a simulated one, whose windows move rims: cameras of one focal length close side by side are not told
LIES = 1 / 40
SCALES = np.exp(np.linspace(np.log(0.56), np.log(1.6), 31))  # one focal length over the other
# standard deviations of all places asked. Of three recordings whose colour was never registered 10.9 to 14.8; of depth
# beside another recording's colours up to 8.4, and never the same in both halves (60 pairs); registered 6.6 to 24.8
REGISTERED, SURE = 5.0, 8.0
# of the best fit at the size it has, that colour may reach where it is: a long straight rim, such as a table's far end,
# fits as well all along itself. 0.93 of such a scene; 0.69, 0.61, 0.25, 0.17 of real colours moved by 4 % (a guess)
AS_WELL = 0.8

Image = NDArray[np.float32]


@dataclass(frozen=True)
class ColorFit:
    """Where colour fits depth best: enlarged by `scale`, moved by `across` and `down` [px]; how far above others."""

    z: float
    here: float  # the same of where it may stay, see `lies`
    scale: float
    across: int
    down: int

    def lies(self, width: int) -> bool:
        """True where colour may stay where it is."""
        return max(abs(self.across), abs(self.down)) <= LIES * width

    def inside(self, width: int) -> bool:
        """True where it is a place among those asked: at their rim it would fit better beyond, so none was found."""
        return abs(self.across) < round(ACROSS * width) and abs(self.down) < round(DOWN * width)

    def near(self, other: "ColorFit", width: int) -> bool:
        """True where both say the same place, to what another depth of the scene makes of it."""
        moved = max(abs(self.across - other.across), abs(self.down - other.down))
        return moved <= LIES * width and abs(np.log(self.scale / other.scale)) < 0.08


def check_color_over_depth(sample: Sample) -> list[Finding]:
    """Colour that lies elsewhere than depth in a way that the frames of both halves of the recording agree on."""
    rims = {i: found for i in sample.colors if (found := rims_of(sample.depths[i])).sum() >= RIMS}
    if not rims:
        return []
    shown = [(rim.astype(np.float32), edges_of(sample.colors[i])) for i, rim in rims.items()]
    width = shown[0][0].shape[1]
    as_is = laid(shown, (1.0,))
    if as_is.z > REGISTERED and as_is.lies(width):
        return [Finding("color", "ok", "colour lies over depth: rims of depth are edges of colour")]
    untold = [Finding("color", "ok", "rims of depth do not tell whether colour lies over it")]
    if as_is.here > max(REGISTERED, AS_WELL * as_is.z):
        return untold
    best = laid(shown, SCALES)
    halves = [laid(shown[k::2], SCALES) for k in (0, 1)] if len(shown) > 1 else []
    agreed = bool(halves) and all(half.near(best, width) and half.inside(width) for half in halves)
    if best.z < SURE or not agreed or not best.inside(width):
        return untold
    seen = f"colour does not lie over depth: it fits when it is enlarged by {best.scale:.2f} and moved by "
    seen += f"{best.across * sample.stride}, {best.down * sample.stride} px"
    do = 'record it registered (aligned) to depth, or pass --camera with its own camera ("color"); scans leave it out'
    return [Finding("color", "warning", seen, do)]


def is_elsewhere(findings: Sequence[Finding]) -> bool:
    """True where colour was found to lie elsewhere than depth."""
    return any(finding.check == "color" and finding.severity == "warning" for finding in findings)


def rims_of(depth: Image) -> NDArray[np.bool_]:
    """(h, w) the near side of steps in depth (h, w) [m], NaN where missing."""
    rims = np.zeros(depth.shape, bool)
    for z, found in ((depth, rims), (depth.T, rims.T)):
        before, near, far, after = z[:, :-3], z[:, 1:-2], z[:, 2:-1], z[:, 3:]
        with np.errstate(invalid="ignore"):
            step = np.abs(far - near)
            fall = np.nan_to_num(np.fmax(np.abs(near - before), np.abs(after - far)))
            ends = (step > STEP * np.minimum(near, far)) & (step > STEEPER * fall)
            found[:, 1:-2] |= ends & (near < far)
            found[:, 2:-1] |= ends & (far < near)
            for gap in (2, 3):  # over pixels without depth
                a, b, hole = z[:, :-gap], z[:, gap:], np.isnan(z[:, 1 : 1 - gap])
                ends = (np.abs(b - a) > STEP * np.minimum(a, b)) & hole[:, : a.shape[1]]
                found[:, :-gap] |= ends & (a < b)
                found[:, gap:] |= ends & (b < a)
    return rims


def edges_of(color: NDArray[np.uint8]) -> Image:
    """(h, w) how strong edges of an image (h, w, 3) are beside what is around them."""
    grey = cv2.GaussianBlur(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY).astype(np.float32), (0, 0), 1)
    strength = np.hypot(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1))
    return np.asarray(np.minimum(strength / (cv2.GaussianBlur(strength, (0, 0), 12) + 2), 4), np.float32)


def laid(shown: Sequence[tuple[Image, Image]], scales: Sequence[float] | NDArray[np.float64]) -> ColorFit:
    """The scale and the shift at which rims lie over edges best.

    Args:
        shown: rims and edges (h, w) of each frame.
        scales: those that are asked.
    """
    return max((_moved(shown, float(scale)) for scale in scales), key=lambda one: one.z)


def _moved(shown: Sequence[tuple[Image, Image]], scale: float) -> ColorFit:
    """The best shift at one scale: sums over frames by the convolution theorem."""
    h, w = shown[0][0].shape
    x, y = round(ACROSS * w), round(DOWN * w)
    size = (cv2.getOptimalDFTSize(h + y), cv2.getOptimalDFTSize(w + x))
    enlarge = np.array([[scale, 0, (1 - scale) * (w - 1) / 2], [0, scale, (1 - scale) * (h - 1) / 2]])
    there = cv2.warpAffine(np.ones((h, w), np.float32), enlarge, (w, h))
    seen = np.fft.rfft2(there, size)
    under, over = np.zeros(size), np.zeros(size)  # sum of edges under rims, rims that meet the image
    for rims, edges in shown:
        moved = cv2.warpAffine(edges, enlarge, (w, h))
        asked = np.conj(np.fft.rfft2(rims, size))
        under += np.fft.irfft2(asked * np.fft.rfft2((moved - moved[there > 0].mean()) * there, size), size)
        over += np.fft.irfft2(asked * seen, size)
    least = sum(float(rims.sum()) for rims, _ in shown) / 4
    fit = np.roll(under / np.sqrt(np.maximum(over, least)), (y, x), axis=(0, 1))[: 2 * y + 1, : 2 * x + 1]
    middle = np.median(fit)
    spread = 1.48 * np.median(np.abs(fit - middle))
    down, across = np.unravel_index(int(fit.argmax()), fit.shape)
    near = round(LIES * w)
    most, here = (
        float((part.max() - middle) / max(spread, 1e-9))
        for part in (fit, fit[max(0, y - near) : y + near + 1, x - near : x + near + 1])
    )
    return ColorFit(most, here, scale, int(across) - x, int(down) - y)
