"""Do the files of furnished rooms hold what their answers tell? A reader of its own, by the contract alone.

python -m tools.trial.furnished.check OUT               all cases that have an answer
python -m tools.trial.furnished.check OUT --only 3 7    these

A line for each case: residuals beside the mesh as told, in standard deviations of the noise as told, with poses fitted.
`temporal` is the spread over frames and `pose` that of the poses' errors, over what is told: 1 where files tell all.
`mean` 0 and `spread` 1 hold where nothing is concealed; `slope` is how much of the change that the physics expect is
found, beside poses: 1 where the effect is there as told, its standard deviation beside it. `raw` is the same without
poses fitted, `large` where the change is well above the noise.
"""

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from tools.trial.furnished.checking.reading import read_case
from tools.trial.furnished.checking.residuals import Gathered, gathered


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path, metavar="OUT", help="what tools.trial.furnished wrote")
    parser.add_argument("--only", type=int, nargs="+", metavar="I", help="these cases alone")
    options = parser.parse_args()
    for file in sorted((options.output / "answers").glob("case_*.json")):
        if options.only and int(file.stem[5:]) not in options.only:
            continue
        answer = json.loads(file.read_text(encoding="utf-8"))
        numbers = " ".join(f"{name} {value:.3f}" for name, value in checked(options.output, file.stem).items())
        what = f"{'+'.join(answer['truth'])}: {answer['size']}" if answer["truth"] else answer["kind"]
        print(f"{file.stem} {numbers} | {answer['sigma']} | {what}", flush=True)


def checked(out: Path, name: str) -> dict[str, float]:
    """Figures of one case, NaN where they say nothing."""
    expected = out / "check" / f"{name}.npz"
    shifts: dict[str, Any] | None = dict(np.load(expected)) if expected.exists() else None
    with warnings.catch_warnings():  # pixels without any depth have no mean, and no variance either
        warnings.filterwarnings("ignore", category=RuntimeWarning)
        return figures(gathered(read_case(out / "cases" / name), shifts))


def figures(got: Gathered) -> dict[str, float]:
    weight, square = sum(got.weight), sum(square for _, square in got.raw)
    slopes = sum(slope * w for slope, w in zip(got.slope, got.weight, strict=True))
    large = np.concatenate(got.large) if got.large else np.zeros(0)
    numbers = {
        "mean": np.mean(got.mean),
        "spread": np.sqrt(np.mean(got.square)),
        "temporal": np.sqrt(np.mean(got.temporal)) if got.temporal else np.nan,
        "pose": np.sqrt(np.mean(got.pose) / np.mean(got.pose_expected)),
        "beyond5": np.mean(got.beyond),
        "valid": np.mean(got.valid),
        "slope": slopes / weight if weight else np.nan,
        "slope_std": 1 / np.sqrt(weight) if weight else np.nan,
        "raw": sum(product for product, _ in got.raw) / square if square > 1 else np.nan,
        "large": np.median(large) if len(large) > 30 else np.nan,
    }
    return {name: float(value) for name, value in numbers.items()}


if __name__ == "__main__":
    main()
