"""Colour images that were left out, predicted by a textured mesh and by its vertex colours: PSNR of both.

    python -m tools.reproduce.scans.texture_held_out out/cup    every 4th colour image of a result of fusion turntable
    python -m tools.reproduce.scans.texture_held_out out/cup --every 3 --pictures out/pictures

Both are made anew from the other images alone and seen from where the left-out images were taken, by Open3D's ray
caster. Pixels: those that both meshes cover, two or more pixels from where the mesh ends or hides itself by more than
1 % of the depth: at a rim both are wrong by the pose and not by the colour; --rims counts them too. The left-out
camera is settled by the print, for each on what that one shows: its pose is as uncertain as those of the others.

Light that stands still while the object turns is found from the images that are used; both are made of images without
it, and seen below it. --baked leaves the vertex colours as `fusion turntable` hands them out, light and all. Three
errors are told: of all, where no exposure is fitted, for neither; of all where each image's one is (a factor for each
channel, that suits it best, for each of the two); and of the print: what is finer than some pixels.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial
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
from fusion.recording.recording import Frame, Recording
from fusion.texture.lighting.light import Lighting
from fusion.texture.result_folder import open_result
from fusion.texture.settled import settled
from fusion.texture.shown import facing, seen_faces, seen_texture
from fusion.texture.textured import TRIANGLES, Textured, texture_mesh

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
    parser.add_argument("--baked", action="store_true", help="vertex colours with the light that they were seen in")
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
    for name, columns in {"all": measured[:, 1:3], "exposed": measured[:, 3:5], "print": measured[:, 5:]}.items():
        texture, vertex = 10 * np.log10(255**2 / np.average(columns, axis=0, weights=measured[:, 0]))
        each = np.array2string(10 * np.log10(columns[:, 1] / columns[:, 0]), precision=2)
        print(f"PSNR {name:<7} texture {texture:.2f} dB, vertex colours {vertex:.2f} dB: {texture - vertex:+.2f} dB")
        print(f"  by image {each}")
    return 0


def measure(mesh: Mesh, taken: list[tuple[Any, Trajectory]], options: argparse.Namespace) -> NDArray[np.float64]:
    """(images, 7) pixels; mean square errors [counts^2] of texture and vertex colours; the same with the exposure
    fitted, and of what is fine."""
    kept, out = [], []
    for number, (recording, course) in enumerate(taken):
        source = color_images(recording)
        if source is None:
            raise FusionError("no colour image", recording.path)
        able = [int(i) for i in source.frames[course.valid[source.frames]]]
        gone = able[options.every // 2 :: options.every]
        poses = course.poses.copy()
        poses[gone] = np.nan
        kept.append((recording, Trajectory(course.timestamps, poses)))
        out += [(number, source, index, source.T_world_color(course.poses[index])) for index in gone]
    colored = color_from(mesh, kept).mesh
    made = texture_mesh(colored, kept, options.triangles)
    print(made.values())
    if not options.baked:
        colored = color_from(mesh, [(evened(made, one, k), course) for k, (one, course) in enumerate(kept)]).mesh
    rows = []
    for number, source, index, T in out:
        image = source.read(index)
        if image is None:
            continue
        below = None if options.baked else made.lights[number]
        shows = [partial(seen_texture, made, light=made.lights[number]), partial(shown_vertices, colored, light=below)]
        (textured, a), (vertices, b) = (fitted(show, source.camera, image.color, T) for show in shows)
        pixels = np.isfinite(a) & np.isfinite(b)
        if not options.rims:
            pixels &= inside(a) & inside(b)
        truth = image.color.astype(float)
        textured, vertices = (np.clip(shown, 0, 255) for shown in (textured, vertices))  # as a camera does
        both = np.isfinite(a) & np.isfinite(b)
        away = [shown - truth for shown in (textured, vertices)]
        exposed = [shown * exposure(shown[pixels], truth[pixels]) - truth for shown in (textured, vertices)]
        fine = [one - coarse(one, both) for one in away]
        rows.append([pixels.sum(), *((one**2)[pixels].mean() for one in (*away, *exposed, *fine))])
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
        picture, depth = show(camera, T)
        v, u = np.nonzero(inside(depth))
        some = np.random.default_rng(0).permutation(len(v))[:SAMPLES]
        u, v = u[some], v[some]
        rays = np.dstack([camera.rays(), np.ones(camera.shape)])[v, u]
        points = transform(T, rays * depth[v, u][:, None].astype(float))
        known = np.isfinite(depth)
        model, image = (one - coarse(one, known) for one in (picture, color.astype(float)))
        T = settled(camera, image.astype(np.float32), stated, T, points, model[v, u].astype(np.float32))
    return show(camera, T)


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


@dataclass(frozen=True)
class Evened(Recording):
    """A recording whose colour images are multiplied with (h, w, 3) `by` of a frame's number."""

    by: Callable[[int], Array] | None = None

    def __getitem__(self, index: int) -> Frame:
        frame = super().__getitem__(index)
        return frame if self.color_is_apart else replace(frame, color=self._even(frame.color, index))

    def color_apart(self, index: int) -> NDArray[np.uint8] | None:
        return self._even(super().color_apart(index), index)

    def _even(self, color: NDArray[np.uint8] | None, index: int) -> NDArray[np.uint8] | None:
        if color is None or self.by is None:
            return color
        return np.clip(np.rint(color * self.by(index)), 0, 255).astype(np.uint8)


def evened(made: Textured, recording: Recording, number: int) -> Recording:
    """A recording without the light and the exposures that a texture was made without."""
    views = made.views
    of = {frame: k for k, frame in enumerate(views.frames) if views.recordings[k] == number}

    def by(index: int) -> Array:
        k = of[index]
        face, share, depth = seen_faces(made.mesh, views.sources[k].camera, views.T_world_color[k])
        known, factor = np.isfinite(depth), np.ones((*depth.shape, 3))
        before = facing(made.mesh, views.T_world_color[k], face[known], share[known])
        factor[known] = made.gain[k] / made.lights[number].on(before)
        return factor

    return Evened(**{one.name: getattr(recording, one.name) for one in fields(recording)}, by=by)


def exposure(shown: Array, truth: Array) -> Array:
    """(3,) factors of the channels with which what is shown (k, 3) suits the truth best."""
    return np.asarray((shown * truth).sum(axis=0) / np.maximum((shown**2).sum(axis=0), 1e-9))


def shown_vertices(
    mesh: Mesh, camera: Camera, T: Array, light: Lighting | None
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """(h, w, 3) what a camera sees of a mesh with colours at its vertices, and its depth (h, w); black and infinite
    beside it."""
    face, share, depth = seen_faces(mesh, camera, T)
    known = np.isfinite(depth)
    out = np.zeros((*depth.shape, 3))
    colors = np.asarray(mesh.colors, float)
    out[known] = (colors[mesh.faces[face[known]]] * share[known][..., None]).sum(axis=1)
    if light is not None:
        out[known] *= light.on(facing(mesh, T, face[known], share[known]))
    return out, depth


if __name__ == "__main__":
    sys.exit(main())
