"""The picture at the top of README.md, from what `fusion demo` made.

python -m tools.documentation.readme_picture DEMO    docs/pictures/scan.png from the folder of `fusion demo -o DEMO`
"""

import argparse
import io
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import fusion
from fusion.files.output.publish import atomic_file
from fusion.mesh.drawing.shading import raised, shaded
from fusion.mesh.drawing.sight import SightSide, sides
from fusion.report.kit.palette import DIVERGING, INK, SOFT, new_figure, styled
from fusion.report.kit.views import Scale, scale_colors

OUT = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "scan.png"
PIXELS = 620  # of the object's longest edge
FRAME = 0  # of the recording: the owl looks at the camera
HIGH, ABOVE, BELOW, GAP = 4.3, 0.35, 0.65, 0.15  # [inch] of a panel, and around it
STEP = 8  # of the PNG's colours
SCALE = Scale(DIVERGING, -1.0, 1.0, "distance to the true surface [mm]")


def panels(demo: Path) -> list[tuple[str, NDArray]]:
    """Titles and pictures (h, w, 4) from left to right."""
    recording = fusion.open_recording(demo / "simulated" / "recording")
    scan, distance = fusion.read_mesh(demo / "mesh.ply"), fusion.read_mesh(demo / "distance.ply")
    around = sides(np.array([0.0, 0.0, 1.0]), np.array([0.9, 0.45, 0.0]))
    front, back = raised(around[0]), raised(around[2])
    clay = fusion.Mesh(scan.vertices, scan.faces, scan.normals)
    errors = scale_colors(1e3 * distance.scalars["signed_distance"], SCALE)
    shown = fusion.Mesh(distance.vertices, distance.faces, distance.normals, (255 * errors).astype(np.uint8))
    rms = json.loads((demo / "comparison.json").read_text(encoding="utf-8"))["accuracy"]["rms"]
    return [
        (f"one of {len(recording)} depth images", _depth(recording[FRAME])),
        ("the scan", _view(scan, front)),
        ("its surface alone", _view(clay, back)),
        (f"its error: {1e3 * rms:.2f} mm rms", _view(shown, front)),
    ]


def _view(mesh: fusion.Mesh, side: SightSide) -> NDArray[np.uint8]:
    return shaded(mesh, side, PIXELS)


def _depth(frame: fusion.Frame) -> NDArray[np.float64]:
    """A depth image as a camera's own viewer shows it, near is bright; cut to the turntable."""
    import matplotlib

    depth = frame.depth[60:420, 195:460]
    near, far = np.nanpercentile(depth, [0.5, 95])
    rgba = matplotlib.colormaps["magma"](1 - 0.85 * np.clip((depth - near) / (far - near), 0, 1))
    rgba[~np.isfinite(depth)] = (0.06, 0.06, 0.09, 1)
    return rgba


def draw(shown: list[tuple[str, NDArray]]) -> bytes:
    """PNG of all panels in a row, on white."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    widths = np.array([HIGH * picture.shape[1] / picture.shape[0] for _, picture in shown])
    left = np.cumsum([GAP, *(widths + GAP)])  # where each panel begins, and the figure ends
    with styled():
        figure = new_figure(float(left[-1]), BELOW + HIGH + ABOVE)
        figure.set_layout_engine("none")
        size = np.array([*figure.get_size_inches()] * 2)
        for x, width, (title, picture) in zip(left[:-1], widths, shown, strict=True):
            ax = figure.add_axes(tuple(np.array([x, BELOW, width, HIGH]) / size))
            ax.imshow(picture, interpolation="antialiased")
            ax.set_axis_off()
            ax.set_title(title, color=INK, fontsize=12, fontweight="normal", loc="center")
        place = np.array([left[-2] + 0.15 * widths[-1], BELOW - 0.2, 0.7 * widths[-1], 0.09])
        bar = figure.colorbar(
            ScalarMappable(Normalize(SCALE.low, SCALE.high), SCALE.cmap),
            cax=figure.add_axes(tuple(place / size)),
            orientation="horizontal",
        )
        bar.outline.set_visible(False)
        bar.set_label(SCALE.label, color=SOFT)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=92, facecolor="white")
    small = io.BytesIO()
    # the last bits of a shaded surface are its noise: without them the file is half as large
    coarse = np.asarray(Image.open(buffer).convert("RGB")).astype(int) // STEP * STEP + STEP - 1
    Image.fromarray(coarse.astype(np.uint8)).save(small, format="png", optimize=True)
    return small.getvalue()


def main(arguments: Any = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("demo", type=Path, metavar="DEMO", help="folder of fusion demo")
    options = parser.parse_args(arguments)
    if not (options.demo / "distance.ply").exists():
        sys.stderr.write(f"{options.demo} is no folder of a demo; first: fusion demo -o {options.demo}\n")
        return 1
    OUT.parent.mkdir(parents=True, exist_ok=True)
    with atomic_file(OUT) as partial:
        partial.write_bytes(draw(panels(options.demo)))
    print(f"{OUT}: {OUT.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
