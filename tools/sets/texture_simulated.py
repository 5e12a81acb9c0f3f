"""Simulated scans of printed objects with a colour camera beside the depth camera, for `texture_held_out.py`.

    python -m tools.sets.texture_simulated -o out/printed --shape statue --seed 1
    fusion turntable out/printed -o out/printed_scan
    python -m tools.reproduce.scans.texture_held_out out/printed_scan

The generator is that of tools/sets/planted_faults.py, which shares no code with the package: a Kinect v2 class depth
camera, a colour camera of 1280 x 720 pixels 52 mm beside it, each of whose pixels is the mean of four rays, exposures
that differ by 5 % from image to image, a light at the camera, print with hard edges in patches of about 12 mm.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from tools.sets.judging.writing import Recording
from tools.sets.planted.shapes import BRIGHT, Paint, waves
from tools.sets.planted.stage import Pinhole, stage_of, turned
from tools.sets.two_passes.cases import CAMERAS, OBJECTS

EVERY = 0.2  # [s]
COLOR = Pinhole(2560, 1440, 1420.0, 1279.5, 719.5)  # halved when it is written
BESIDE = 0.052  # [m]
EXPOSURE = 0.05


def main() -> None:
    """Make one recording."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
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
    behind = stage.backdrop(stage.T_world_camera), seer.backdrop(stage.T_world_camera @ T_depth_color)
    recording = Recording(options.output, _camera(device.camera))
    angles = np.linspace(0, 354, options.frames) + 0.05 * rng.standard_normal(options.frames)
    for i, angle in enumerate(angles):
        T, time = turned(angle), 100 + EVERY * i
        recording.depth(time, device.depth(stage.seen(behind[0], T, T)[0], 0.0, rng))
        colours = seer.seen(behind[1], T, T)[1]
        half = cv2.resize(colours, (COLOR.width // 2, COLOR.height // 2), interpolation=cv2.INTER_AREA).astype(float)
        half = half * (1 + EXPOSURE * rng.standard_normal()) + rng.normal(0, 2, half.shape)
        recording.rgb(time, np.clip(np.rint(half), 0, 255).astype(np.uint8))
    recording.done(turntable_deg=angles)


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
