"""Turntable steps of the recording kleenex_turntable, measured from its colour images only.

Four red stickers lie on the white disc; one has a black strip. Each is found in every frame where it is in view, and
one least-squares fit gives the disc's plane and centre, radius and bearing of each sticker, and one turn per frame.
Nothing of the box, of the depth images or of a tracker is used.

The focal length is fitted too unless --focal states it: the stickers' path tells it, and the turn hardly needs it.

    python -m tools.reproduce.scans.kleenex_markers [--shared ../shared] [--json] [--focal PX] [--overlay FILE.png]
"""

import argparse
import json
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from fusion.errors import FusionError

DISC = (315.0, 295.0, 104.0, 49.0)  # rough outline of the disc: centre u, v and half axes [px]
STICKERS = 4


class Blobs(NamedTuple):
    """Sticker sightings: frame (n,), centre (n, 2) [px], dark (n,) number of black pixels around it."""

    frame: NDArray[np.intp]
    centre: NDArray[np.float64]
    dark: NDArray[np.intp]


def find_stickers(images: list[NDArray[Any]]) -> Blobs:
    """Red blobs in the rim of the disc, in BGR images; their centres are weighted by how red a pixel is."""
    v, u = np.mgrid[: images[0].shape[0], : images[0].shape[1]]
    rim = np.abs(np.hypot((u - DISC[0]) / DISC[2], (v - DISC[1]) / DISC[3]) - 0.92) < 0.17
    rows = []
    for frame, image in enumerate(images):
        hue, saturation, value = cv2.split(cv2.cvtColor(image, cv2.COLOR_BGR2HSV))
        red = ((hue < 10) | (hue > 165)) & (saturation > 80) & rim
        count, label, stats, _ = cv2.connectedComponentsWithStats(red.astype(np.uint8))
        for k in (k for k in range(1, count) if stats[k, cv2.CC_STAT_AREA] >= 18):
            inside = label == k
            weight = np.where(inside, saturation - 60.0, 0.0)
            near = cv2.dilate(inside.astype(np.uint8), np.ones((11, 11), np.uint8)) > 0
            centre = np.array([(u * weight).sum(), (v * weight).sum()]) / weight.sum()
            rows.append((frame, *centre, int(np.count_nonzero(near & (value < 95)))))
    table = np.array(rows, dtype=float).reshape(-1, 4)
    return Blobs(table[:, 0].astype(int), table[:, 1:3], table[:, 3].astype(int))


def project(disc: NDArray[np.float64], polar: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (n, 2) of points `polar` (n, 2) = (radius * focal / centre's distance [px], bearing [rad]) on the disc.

    `disc` = (centre u, v [px], tilt, roll [rad], focal length [px]), `middle` = (cx, cy) [px]. Bearings count
    right-handed about the normal that points up.
    """
    tilt, roll, focal = disc[2:5]
    normal = np.array([np.sin(roll), -np.cos(roll) * np.cos(tilt), -np.cos(roll) * np.sin(tilt)])
    right = np.array([1.0, 0, 0]) - normal[0] * normal
    right /= np.linalg.norm(right)
    away = np.cross(normal, right)
    centre = np.append((disc[:2] - middle) / focal, 1.0)
    bearing = polar[:, 1:]
    points = centre + polar[:, :1] / focal * (np.cos(bearing) * right + np.sin(bearing) * away)
    return focal * points[:, :2] / points[:, 2:] + middle


def name_stickers(blobs: Blobs, frames: int) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """First guess: sticker of each blob (n,), and turn per frame (frames,) [rad].

    The stickers are about 90 deg apart, so that one frame tells the turn but for quarter turns; the step is taken below
    an eighth of a turn. That this names them rightly is proved by the black strip, which must stay with one of them.
    """
    u, v = blobs.centre.T
    bearing = np.arctan2((DISC[1] - v) / DISC[3], (u - DISC[0]) / DISC[2])
    phase = np.array([np.angle(np.exp(4j * bearing[blobs.frame == k]).sum()) for k in range(frames)])
    turn = np.unwrap(phase) / STICKERS
    name = np.round((bearing - turn[blobs.frame]) / (np.pi / 2)).astype(int) % STICKERS
    return name, turn - turn[0]


def fit(blobs: Blobs, camera: dict[str, Any], focal: float | None = None) -> dict[str, Any]:
    """Disc, stickers and turn per frame by robust least squares; standard errors from its normal matrix."""
    name, turn = name_stickers(blobs, int(np.max(blobs.frame)) + 1)
    u, v = blobs.centre[0]
    first = np.arctan2((DISC[1] - v) / DISC[3], (u - DISC[0]) / DISC[2]) - np.pi / 2 * name[0]
    bearings = first + np.pi / 2 * np.arange(STICKERS)
    middle = np.array([camera["cx"], camera["cy"]])
    start = np.concatenate([[*DISC[:2], 0.5, 0.0, focal or camera["fx"]], np.full(STICKERS, DISC[2]), bearings, turn])
    free = np.ones(len(start), bool)
    free[4], free[13] = focal is None, False  # the turn counts from frame 0

    def residuals(moved: NDArray[np.float64]) -> NDArray[np.float64]:
        x = start.copy()
        x[free] = moved
        polar = np.column_stack([x[5:9][name], x[9:13][name] + x[13:][blobs.frame]])
        return (project(x[:5], polar, middle) - blobs.centre).ravel()

    found = least_squares(residuals, start[free], loss="soft_l1", f_scale=0.7, x_scale="jac")
    # a blob that the box hides in part has its centre in the wrong place
    good = np.hypot(*residuals(found.x).reshape(-1, 2).T) < 2.5
    kept = np.repeat(good, 2)
    found = least_squares(lambda x: residuals(x)[kept], found.x, x_scale="jac")
    covariance = np.zeros((len(start), len(start)))
    variance = 2 * found.cost / (kept.sum() - free.sum())
    covariance[np.ix_(free, free)] = variance * np.linalg.inv(found.jac.T @ found.jac)
    start[free] = found.x
    rms = float(np.sqrt(2 * found.cost / good.sum()))
    return {"x": start, "covariance": covariance, "rms_px": rms, "good": good, "name": name, "middle": middle}


def summary(blobs: Blobs, result: dict[str, Any]) -> dict[str, Any]:
    """Steps, total and the rest of the turn in degrees, with standard errors (`_se`)."""
    x, good = result["x"], result["good"]
    turn, covariance = np.degrees(x[13:]), result["covariance"][13:, 13:] * np.degrees(1) ** 2
    difference = np.diff(np.eye(len(turn)), axis=0)
    steps, total, total_se = np.diff(turn), float(turn[-1]), float(np.sqrt(covariance[-1, -1]))
    strip = np.flatnonzero((blobs.dark >= 5) & good)
    return {
        "steps_deg": np.round(steps, 2).tolist(),
        "steps_se_deg": np.round(np.sqrt(np.diag(difference @ covariance @ difference.T)), 2).tolist(),
        "mean_step_deg": total / len(steps),
        "mean_step_se_deg": total_se / len(steps),
        "step_std_deg": float(steps.std(ddof=1)),
        "total_deg": total,
        "rest_deg": 360.0 - total,
        "total_se_deg": total_se,
        "focal_px": float(x[4]),
        "focal_se_px": float(np.sqrt(result["covariance"][4, 4])),
        "tilt_deg": float(np.degrees(x[2])),
        "sticker_bearings_deg": np.round(np.degrees(x[9:13] - x[9]) % 360, 2).tolist(),
        "sticker_radii_px": np.round(x[5:9], 2).tolist(),
        "rms_px": result["rms_px"],
        "sightings": int(good.sum()),
        "left_out": [(int(blobs.frame[k]), *np.round(blobs.centre[k], 1).tolist()) for k in np.flatnonzero(~good)],
        "black_strip_seen_in_frames": blobs.frame[strip].tolist(),
        "black_strip_on_stickers": sorted({int(k) for k in result["name"][strip]}),
    }


def draw(images: list[NDArray[Any]], blobs: Blobs, result: dict[str, Any], path: Path) -> None:
    """All frames with the fitted sticker places (circles with numbers, also where hidden) and the blobs (crosses)."""
    x, tiles = result["x"], []
    for frame, image in enumerate(images):
        crop = cv2.resize(image[235:355, 200:430], None, fx=3, fy=3, interpolation=cv2.INTER_CUBIC)
        for k, (u, v) in enumerate(
            project(x[:5], np.column_stack([x[5:9], x[9:13] + x[13 + frame]]), result["middle"])
        ):
            at = (round(3 * (u - 200) + 1), round(3 * (v - 235) + 1))
            cv2.circle(crop, at, 14, (0, 160, 0), 2)
            cv2.putText(crop, str(k), (at[0] - 6, at[1] - 18), 0, 0.8, (0, 160, 0), 2)
        for u, v in blobs.centre[blobs.frame == frame]:
            cv2.drawMarker(crop, (round(3 * (u - 200) + 1), round(3 * (v - 235) + 1)), (255, 0, 0), markerSize=10)
        cv2.putText(crop, f"frame {frame}", (5, 350), 0, 0.8, (255, 0, 0), 2)
        tiles.append(crop)
    tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % 4)
    if not cv2.imwrite(str(path), np.vstack([np.hstack(tiles[k : k + 4]) for k in range(0, len(tiles), 4)])):
        raise FusionError("the overlay could not be written", where=path, do="state a file in an existing folder")


def load(folder: Path) -> tuple[list[NDArray[Any]], dict[str, Any]]:
    """BGR images and the stated camera of the recording; raises FusionError where they are not there."""
    files = sorted((folder / "rgb").glob("*.jpg"))
    images = [image for image in (cv2.imread(str(file)) for file in files) if image is not None]
    if len(images) < 2 or not (folder / "camera.json").is_file():
        raise FusionError("no recording", folder, f"{len(images)} images", "rgb/*.jpg, camera.json", "state --shared")
    return images, json.loads((folder / "camera.json").read_text())


def main() -> None:
    """Print the measurement."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=Path("../shared"))
    parser.add_argument("--focal", type=float, help="hold the focal length [px], camera.json says 525")
    parser.add_argument("--overlay", type=Path, help="draw fit and blobs over the images")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    try:
        images, camera = load(options.shared / "data" / "kleenex_turntable")
        blobs = find_stickers(images)
        result = fit(blobs, camera, options.focal)
        if options.overlay:
            draw(images, blobs, result, options.overlay)
    except FusionError as error:
        raise SystemExit(f"error: {error}") from None
    found = summary(blobs, result)
    print(json.dumps(found) if options.json else "\n".join(f"{key:27} {value}" for key, value in found.items()))


if __name__ == "__main__":
    main()
