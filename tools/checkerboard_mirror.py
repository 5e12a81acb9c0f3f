"""What the real Kinect v2 checkerboard leaves over: light that the dark squares' gloss mirrors into the camera.

    python tools/checkerboard_depth.py --output DIR && python tools/checkerboard_mirror.py DIR

In four of 55 views dark squares read 20 to 100 mm too far: those in which the mirrored line of sight meets the chair's
seat. Here every square gets what one mirror bounce would do: IR and depth of the image give the light and the place of
every surface, a lobe of 10 degrees about the mirror direction gathers it, and it joins the direct light as a phasor at
each modulation. ONE number is fitted, the share of light that is mirrored; Fresnel's formulas give 0.04 for plastic
and paper (index 1.5). The last lines say how much of the held-out error it explains: no law of a single pixel can.
"""

import argparse
import json
import sys
from pathlib import Path

import cv2
import numpy as np
from checkerboard_depth import Squares, rms, squares
from numpy.typing import NDArray

from fusion.calibration.depth.board_walls import seen_board
from fusion.calibration.lens.board import read_board
from fusion.geometry.camera import Camera
from fusion.recording.camera_file import read_camera
from fusion.recording.open import open_recording
from fusion.recording.recording import Frame
from fusion.sensor.view import LIGHT_SPEED, MODULATIONS_HZ

LOBE = np.radians(10.0)  # of toner on paper (guess); 20 degrees explain as much
STEP = 4  # [px] between the pixels whose light is gathered
NEAR = 0.03  # [m] from the square: nearer is the board itself
EDGE_ON = 0.15  # cosine of the incidence below which a surface's area in a pixel is not known
Array = NDArray[np.float64]


def surfaces(frame: Frame, camera: Camera) -> tuple[Array, Array, Array, Array]:
    """Places (n, 3) [m], normals (n, 3), areas (n,) [m^2] and light (n,) [count] of the surfaces in a frame."""
    assert frame.ir is not None
    depth = np.asarray(cv2.GaussianBlur(np.asarray(frame.depth), (0, 0), 1.0), float)
    points = camera.points(depth)
    normal = np.cross(np.gradient(points, axis=1), np.gradient(points, axis=0))
    area = np.linalg.norm(normal, axis=2)
    normal /= np.maximum(area, 1e-12)[..., None]
    facing = (normal * points).sum(axis=2) / np.linalg.norm(points, axis=2)
    normal *= -np.sign(facing)[..., None]
    used = np.zeros(camera.shape, bool)
    used[::STEP, ::STEP] = True
    used &= np.isfinite(area) & (np.abs(facing) > EDGE_ON) & np.isfinite(frame.depth)
    place = np.asarray(camera.points(np.asarray(frame.depth)), float)[used]
    return place, normal[used], area[used] * STEP**2, np.asarray(frame.ir, float)[used]


def mirrored(point: Array, normal: Array, own: float, seen: tuple[Array, Array, Array, Array]) -> float:
    """Change of the range [m] per unit of mirrored share, for a square at `point` (3,) with `own` light [count]."""
    place, facing, area, light = seen
    ray = point / np.linalg.norm(point)
    mirror = ray - 2 * (ray @ normal) * normal
    to = place - point
    length = np.linalg.norm(to, axis=1)
    to /= np.maximum(length, 1e-9)[:, None]
    cosine = -(facing * to).sum(axis=1)
    use = (to @ normal > 0.02) & (length > NEAR) & (cosine > 0)
    off = np.arccos(np.clip(to @ mirror, -1, 1))
    lobe = np.exp(-0.5 * (off / LOBE) ** 2) / (2 * np.pi * LOBE**2)
    gathered = np.where(use, light * area * cosine / np.maximum(length, NEAR) ** 2 * lobe, 0.0)
    # from the lamp to the surface, to the square and back, less twice the square's range
    longer = np.linalg.norm(place, axis=1) + length - np.linalg.norm(point)
    total = sum(f**2 for f in MODULATIONS_HZ)
    parts = [f * (gathered * np.sin(2 * np.pi * f * longer / LIGHT_SPEED)).sum() for f in MODULATIONS_HZ]
    return float(sum(parts)) / total * LIGHT_SPEED / (4 * np.pi) / max(own, 1.0)


def term(folder: Path, camera: Camera, at: Squares) -> Array:
    """(n,) change of the depth [m] per unit of mirrored share at every square."""
    recording, board = open_recording(folder / "recording"), read_board(folder / "board.json")
    rays = np.dstack([camera.rays(), np.ones(camera.shape)]).astype(float)
    out = np.zeros(len(at.error))
    for view in np.unique(at.view):
        frame = recording[int(view)]
        found = seen_board(frame, camera, board)
        assert found is not None  # its squares were measured
        normal = np.asarray(cv2.Rodrigues(found[1][:3])[0][:, 2], float)
        normal = normal if normal @ found[1][3:] < 0 else -normal
        seen = surfaces(frame, camera)
        for i in np.flatnonzero(at.view == view):
            ray = rays[at.pixel[i, 1], at.pixel[i, 0]]
            out[i] = mirrored(ray * at.depth[i], normal, float(at.ir[i]), seen) / np.linalg.norm(ray)
    return out


def held_out(at: Squares, columns: list[Array]) -> tuple[Array, Array]:
    """Errors (n,) [m] of views left out one by one after least squares on the others, and the numbers (v, k)."""
    A, left, numbers = np.column_stack(columns), np.zeros(len(at.error)), []
    for view in np.unique(at.view):
        out = at.view == view
        numbers.append(np.linalg.lstsq(A[~out], at.error[~out], rcond=None)[0])
        left[out] = at.error[out] - A[out] @ numbers[-1]
    return left, np.array(numbers)


def undone(at: Squares, found: tuple[Array, Array]) -> Array:
    """Errors (n,) [m] as the corrected depth has them: what is left of the measured one, the scale taken out."""
    left, numbers = found
    return left / (1 + numbers[np.searchsorted(np.unique(at.view), at.view), 1])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="what checkerboard_depth.py --output wrote")
    options = parser.parse_args()
    camera = read_camera(options.folder / "lens" / "camera.json")
    at = squares(options.folder, camera)
    mirror, dark = term(options.folder, camera, at), np.median(at.ir) / at.ir
    line = [np.ones(len(at.error)), at.depth]
    pixel = [*line, dark**2, np.log(dark), *at.pixel.T.astype(float)]
    laws = {"line": line, "pixel by pixel": pixel, "line and mirror": [*line, mirror], "both": [*pixel, mirror]}
    found = {name: held_out(at, columns) for name, columns in laws.items()}
    share = found["both"][1][:, -1]
    n = len(share)
    result = {
        **{f"held_out_{name.replace(' ', '_')}_mm": 1e3 * rms(left) for name, (left, _) in found.items()},
        "share_of_line_pixel_by_pixel": rms(found["pixel by pixel"][0]) / rms(found["line"][0]),
        # what to expect of a calibration at best: this fit sees only these squares, and the sum that it makes least
        "the_same_undone": rms(undone(at, found["pixel by pixel"])) / rms(found["line"][0]),
        "the_same_undone_line_too": rms(undone(at, found["pixel by pixel"])) / rms(undone(at, found["line"])),
        "share_of_line_both": rms(found["both"][0]) / rms(found["line"][0]),
        "mirrored_share": float(share.mean()),
        "mirrored_share_std": float(np.sqrt((n - 1) / n * ((share - share.mean()) ** 2).sum())),  # jackknife
        "fresnel_of_index_1_5": 0.04,
    }
    print(json.dumps(result, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
