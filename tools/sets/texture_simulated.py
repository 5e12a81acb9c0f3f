"""Simulated scans of printed objects with a colour camera beside the depth camera, for `texture_held_out.py`.

    python -m tools.sets.texture_simulated -o out/printed --shape statue --seed 1
    fusion turntable out/printed -o out/printed_scan
    python -m tools.reproduce.scans.texture_held_out out/printed_scan
    python -m tools.sets.texture_simulated --shape statue --seed 31 --limit     how good could any texture be?

The generator is that of tools/sets/planted_faults.py, which shares no code with the package: a Kinect v2 class depth
camera, a colour camera of 1280 x 720 pixels 52 mm beside it, each of whose pixels is the mean of four rays, exposures
that differ by 5 % from image to image, a light at the camera, print with hard edges in patches of about 12 mm.

`--limit`: PSNR of what nothing could foretell better, beside images with their noise and exposures, on the object away
from rims. `perfect`: the image itself without noise, exposure as it is or fitted. `ideal texture`: true colours as one
camera pixel mixes them, seen once more through such a pixel: what no texture made of such images exceeds without
undoing blur, true poses and true shape given.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sets.judging.writing import Recording
from tools.sets.planted.shapes import BRIGHT, Paint, waves
from tools.sets.planted.stage import OBJECT, Pinhole, Stage, stage_of, turned
from tools.sets.two_passes.cases import CAMERAS, OBJECTS

EVERY = 0.2  # [s]
COLOR = Pinhole(2560, 1440, 1420.0, 1279.5, 719.5)  # halved when it is written
BESIDE = 0.052  # [m]
EXPOSURE = 0.05
BOX = np.array([0.25, 0.5, 0.25])
LIMIT, RIM = 8, 2  # images; [px] from the object's rim


def main() -> None:
    """Make one recording."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--limit", action="store_true", help="make nothing; print how good a texture could be")
    parser.add_argument("--shape", choices=OBJECTS, default="statue")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--frames", type=int, default=60)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    device = CAMERAS["kinect-v2"]
    item = OBJECTS[options.shape](rng, rng.uniform(0.18, 0.24))
    stage = stage_of(rng, device.camera, item, rng.uniform(0.7, 0.8))
    print_ = Paint(waves(rng, 0.012), waves(rng, 0.004), BRIGHT)
    stage = replace(stage, paints=(stage.paints[0], stage.paints[1], print_))
    seer = replace(stage, camera=COLOR)
    T_depth_color = np.eye(4)
    T_depth_color[0, 3] = BESIDE
    if options.limit:
        print(limit(replace(seer, camera=COLOR), T_depth_color, rng))
        return
    if options.output is None:
        parser.error("-o is missing")
    behind = stage.backdrop(stage.T_world_camera), seer.backdrop(stage.T_world_camera @ T_depth_color)
    recording = Recording(options.output, _camera(device.camera))
    angles = np.linspace(0, 354, options.frames) + 0.05 * rng.standard_normal(options.frames)
    for i, angle in enumerate(angles):
        T, time = turned(angle), 100 + EVERY * i
        recording.depth(time, device.depth(stage.seen(behind[0], T, T)[0], 0.0, rng))
        colours = seer.seen(behind[1], T, T)[1]
        recording.rgb(time, taken(halved(colours), rng))
    recording.done(turntable_deg=angles)


def halved(colours: NDArray[Any]) -> NDArray[np.float64]:
    """(h, w, 3) each pixel the mean of four."""
    return cv2.resize(colours, (COLOR.width // 2, COLOR.height // 2), interpolation=cv2.INTER_AREA).astype(float)


def taken(picture: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.uint8]:
    """As the camera writes it: with an exposure of its own, and noise."""
    half = picture * (1 + EXPOSURE * rng.standard_normal()) + rng.normal(0, 2, picture.shape)
    return np.clip(np.rint(half), 0, 255).astype(np.uint8)


def limit(seer: Stage, T_depth_color: NDArray[np.float64], rng: np.random.Generator) -> str:
    """How well what nothing exceeds would foretell some images."""
    behind, errors = seer.backdrop(seer.T_world_camera @ T_depth_color), []
    for angle in np.arange(LIMIT) * 360 / LIMIT:
        hits, colours = seer.seen(behind, turned(angle), turned(angle))
        near = cv2.erode((hits.part == OBJECT).astype(np.uint8), np.ones((3, 3)), iterations=2 * RIM)[::2, ::2] > 0
        picture = halved(colours)
        image = taken(picture, rng).astype(float)
        # a texel mixes what a pixel does: a box as wide, over what lies between the fine pixels, is 1/4, 1/2, 1/4
        twice = halved(cv2.sepFilter2D(colours, -1, BOX, BOX))
        for shown in (picture, twice):
            fit = (shown * image)[near].sum(axis=0) / (shown**2)[near].sum(axis=0)
            errors += [((shown - image)[near] ** 2).mean(), ((shown * fit - image)[near] ** 2).mean()]
    perfect, fitted, once, ideal = 10 * np.log10(255**2 / np.reshape(errors, (-1, 4)).mean(axis=0))
    return f"perfect {perfect:.1f} dB, exposed {fitted:.1f}; ideal texture {once:.1f} dB, exposed {ideal:.1f}"


def _camera(depth: Pinhole) -> dict[str, object]:
    def lens(camera: Pinhole, share: float) -> dict[str, object]:
        middle = {"cx": (camera.cx + 0.5) * share - 0.5, "cy": (camera.cy + 0.5) * share - 0.5}
        size = {"width": int(camera.width * share), "height": int(camera.height * share)}
        return size | {"fx": camera.f * share, "fy": camera.f * share} | middle | {"distortion": [0.0] * 5}

    T = np.eye(4)
    T[0, 3] = -BESIDE
    std = {"fx": 0.001 * depth.f, "fy": 0.001 * depth.f, "cx": 0.5, "cy": 0.5}
    kind = {"depth_scale": 1000.0, "principle": "itof", "sensor": "kinect-v2", "std": std}
    return lens(depth, 1.0) | kind | {"color": lens(COLOR, 0.5) | {"T_color_depth": T.tolist()}}


if __name__ == "__main__":
    main()
