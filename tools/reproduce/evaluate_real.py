"""Figures of `fusion evaluate` on real recordings: what is asked and what is reached.

python -m tools.reproduce.evaluate_real [--shared ../shared]
"""

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fusion.evaluation.evaluate import evaluate
from fusion.evaluation.summary import Evaluation
from fusion.recording.open import open_recording
from tools.reproduce.adapt_recordings import adapt

RING = 40.0  # [px] wide, as in the set's SOURCE.md
EDGE = 280.0  # [px] from the centre
NOISE_CENTRE, NOISE_EDGE, NOISE_WITHIN = 0.013, 0.053, 0.15  # [m], [m], share
DIP = 0.0093  # [m] ring 120-160 px less ring 0-40 px, SOURCE.md: (25 + 111) counts; of it a half must be seen
STEP, STEP_WITHIN = 0.00285, 0.03  # [m] at 1 m, share


@dataclass(frozen=True)
class Figure:
    """One number: what it is, asked and reached, whether it is good enough."""

    name: str
    asked: str
    reached: str
    good: bool


def floor(shared: Path, folder: Path) -> list[Figure]:
    """Kinect v2 above a floor, a person walking through."""
    return floor_figures(_evaluated("kinect_v2_floor", shared, folder))


def floor_figures(found: Evaluation) -> list[Figure]:
    """Noise at centre and edge, the dip of the centre."""
    look = found.looks[0]
    assert look.bias is not None
    inner, outer = ring(look.still.depth.std, 0, RING), ring(look.still.depth.std, EDGE, np.inf)
    mad = [1e3 * ring(look.still.robust, *limits) for limits in ((0, RING), (EDGE, np.inf))]
    dip = ring(look.bias.residual, 3 * RING, 4 * RING) - ring(look.bias.residual, 0, RING)
    return [
        Figure("floor, noise at the centre", "13 mm within 15 %", f"{1e3 * inner:.1f} mm (MAD {mad[0]:.1f})",
               abs(inner / NOISE_CENTRE - 1) <= NOISE_WITHIN),
        Figure("floor, noise beyond 280 px", "53 mm within 15 %", f"{1e3 * outer:.1f} mm (MAD {mad[1]:.1f})",
               abs(outer / NOISE_EDGE - 1) <= NOISE_WITHIN),
        Figure("floor, dip of the centre", "about 9.3 mm", f"{1e3 * dip:.1f} mm", 0.5 * DIP < dip < 1.5 * DIP),
    ]  # fmt: skip


def ring(image: np.ndarray, low: float, high: float) -> float:
    """Median over the pixels at this distance [px] from the middle of the image."""
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    radius = np.hypot(u - (image.shape[1] - 1) / 2, v - (image.shape[0] - 1) / 2)
    return float(np.nanmedian(image[(radius >= low) & (radius < high)]))


def corner(shared: Path, folder: Path) -> list[Figure]:
    """Kinect v1, one frame at each of five distances."""
    found = _evaluated("checkerboard_corner", shared, folder)
    q = found.quantization
    assert q is not None
    reached = f"{1e3 * q.value:.3f} mm, law {q.law}, exponent {q.exponent:.3f}"
    good = q.law == "z^2" and abs(q.value / STEP - 1) <= STEP_WITHIN
    single = [look.quantization.value if look.quantization else np.nan for look in found.looks]
    worst = float(np.max(np.abs(np.array(single) / STEP - 1)))
    return [
        Figure("corner, step over z^2", "2.85 mm within 3 %", reached, good),
        Figure("corner, each single frame", "2.85 mm within 3 %", f"worst {100 * worst:.1f} %", worst <= STEP_WITHIN),
    ]


def _evaluated(name: str, shared: Path, folder: Path) -> Evaluation:
    return evaluate([open_recording(path) for path in adapt(name, shared, folder / name)])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        figures = [*floor(options.shared, Path(name)), *corner(options.shared, Path(name))]
    for figure in figures:
        print(f"{figure.name:28} asked {figure.asked:20} reached {figure.reached}{'' if figure.good else '  !'}")
    return 0 if all(figure.good for figure in figures) else 1


if __name__ == "__main__":
    sys.exit(main())
