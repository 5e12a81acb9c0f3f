"""Colour images that were left out, predicted by a textured mesh and by its vertex colours: PSNR of both.

    python -m tools.reproduce.scans.texture_held_out out/cup    every 4th colour image of a result of fusion turntable
    python -m tools.reproduce.scans.texture_held_out out/cup --every 3 --pictures out/pictures

Both are made anew from the other images alone and seen from where the left-out images were taken, by Open3D's ray
caster. Pixels: those that both meshes cover, two or more pixels from where the mesh ends or hides itself by more than
1 % of the depth: at a rim both are wrong by the pose and not by the colour; --rims counts them too. No exposure is
fitted, for neither; the left-out camera is settled by the print, for each on what that one shows: its pose is as
uncertain as those of the others. On a turntable before lamps that stand still a side's brightness changes while it
turns, which no colour on a surface can show; so the fine part is told too: all three images without what is coarser
than some pixels, that is the print.
"""

import argparse
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.coloring.color_mesh import color_from
from fusion.coloring.images import color_images
from fusion.errors import FusionError
from fusion.geometry.camera import Camera
from fusion.geometry.pose import Array, transform
from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.texture.result_folder import open_result
from fusion.texture.settled import settled
from fusion.texture.shown import seen_faces, seen_texture
from fusion.texture.textured import TRIANGLES, texture_mesh

JUMP, RIM = 0.01, 2  # of the depth; [px]
SAMPLES = 20_000
COARSE = 6.0  # [px] standard deviation


def main() -> int:
    """Predict, compare, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result", type=Path)
    parser.add_argument("--every", type=int, default=4)
    parser.add_argument("--triangles", type=int, default=TRIANGLES)
    parser.add_argument("--camera", help="of the recording, if it says none")
    parser.add_argument("--rims", action="store_true", help="rims count too")
    parser.add_argument("--pictures", type=Path, help="folder for photograph, texture, vertex colours side by side")
    options = parser.parse_args()
    try:
        mesh, taken = open_result(options.result, camera=options.camera)
        measured = measure(mesh, taken, options)
    except FusionError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    print(f"{len(measured)} images left out, {int(measured[:, 0].sum())} pixels")
    for name, columns in {"all": measured[:, 1:3], "fine": measured[:, 3:]}.items():
        texture, vertex = 10 * np.log10(255**2 / np.average(columns, axis=0, weights=measured[:, 0]))
        each = np.array2string(10 * np.log10(columns[:, 1] / columns[:, 0]), precision=2)
        print(f"PSNR {name:<4} texture {texture:.2f} dB, vertex colours {vertex:.2f} dB: {texture - vertex:+.2f} dB")
        print(f"  by image {each}")
    return 0


def measure(mesh: Mesh, taken: list[tuple[Any, Trajectory]], options: argparse.Namespace) -> NDArray[np.float64]:
    """(images, 5) pixels; mean square errors [counts^2] of texture and vertex colours; the same of what is fine."""
    kept, out = [], []
    for recording, course in taken:
        source = color_images(recording)
        if source is None:
            raise FusionError("no colour image", recording.path)
        able = [int(i) for i in source.frames[course.valid[source.frames]]]
        gone = able[options.every // 2 :: options.every]
        poses = course.poses.copy()
        poses[gone] = np.nan
        kept.append((recording, Trajectory(course.timestamps, poses)))
        out += [(source, index, source.T_world_color(course.poses[index])) for index in gone]
    colored = color_from(mesh, kept).mesh
    made = texture_mesh(colored, kept, options.triangles)
    print(made.values())
    rows = []
    for source, index, T in out:
        image = source.read(index)
        if image is None:
            continue
        textured, a = fitted(lambda T, s=source: seen_texture(made, s.camera, T), source.camera, image.color, T)
        vertices, b = fitted(lambda T, s=source: shown_vertices(colored, s.camera, T), source.camera, image.color, T)
        pixels = np.isfinite(a) & np.isfinite(b)
        if not options.rims:
            pixels &= inside(a) & inside(b)
        truth = image.color.astype(float)
        away = [shown - truth for shown in (textured, vertices)]
        fine = [one - coarse(one, np.isfinite(a) & np.isfinite(b)) for one in away]
        rows.append([pixels.sum(), *((one**2)[pixels].mean() for one in (*away, *fine))])
        if options.pictures:
            options.pictures.mkdir(parents=True, exist_ok=True)
            v, u = np.nonzero(np.isfinite(a))
            cut = np.s_[max(v.min() - 8, 0) : v.max() + 8, max(u.min() - 8, 0) : u.max() + 8]
            beside = np.hstack([truth[cut], textured[cut], vertices[cut]])
            cv2.imwrite(str(options.pictures / f"{index:04d}.png"), np.rint(beside[..., ::-1]).astype(np.uint8))
    return np.array(rows)


def fitted(show: Any, camera: Camera, color: NDArray[np.uint8], stated: Array) -> Any:
    """What `show` gives at the place where the image fits it best, by the print."""
    T = stated
    for _ in range(2):
        picture, depth = show(T)
        v, u = np.nonzero(inside(depth))
        some = np.random.default_rng(0).permutation(len(v))[:SAMPLES]
        u, v = u[some], v[some]
        rays = np.dstack([camera.rays(), np.ones(camera.shape)])[v, u]
        points = transform(T, rays * depth[v, u][:, None].astype(float))
        known = np.isfinite(depth)
        model, image = (one - coarse(one, known) for one in (picture, color.astype(float)))
        T = settled(camera, image.astype(np.float32), stated, T, points, model[v, u].astype(np.float32))
    return show(T)


def coarse(picture: NDArray[np.float64], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(h, w, 3) mean over some pixels of a picture, of those that are known (h, w)."""
    share = cv2.GaussianBlur(known.astype(float), (0, 0), COARSE)
    total = cv2.GaussianBlur(np.where(known[..., None], picture, 0.0), (0, 0), COARSE)
    return np.asarray(total / np.maximum(share, 1e-6)[..., None])


def inside(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(h, w) pixels away from rims of a depth image, infinite where there is nothing."""
    known = np.where(np.isfinite(depth), depth, 99).astype(np.float32)
    box = np.ones((3, 3), np.uint8)
    jump = cv2.dilate(known, box) - cv2.erode(known, box) > JUMP * known
    return cv2.distanceTransform((~jump & np.isfinite(depth)).astype(np.uint8), cv2.DIST_L2, 5) > RIM


def shown_vertices(mesh: Mesh, camera: Camera, T: Array) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """(h, w, 3) what a camera sees of a mesh with colours at its vertices, and its depth (h, w); black and infinite
    beside it."""
    face, share, depth = seen_faces(mesh, camera, T)
    known = np.isfinite(depth)
    out = np.zeros((*depth.shape, 3))
    colors = np.asarray(mesh.colors, float)
    out[known] = (colors[mesh.faces[face[known]]] * share[known][..., None]).sum(axis=1)
    return out, depth


if __name__ == "__main__":
    sys.exit(main())
