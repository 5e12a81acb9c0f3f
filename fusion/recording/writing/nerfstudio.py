"""Writing a recording for programs that make splats: nerfstudio's `transforms.json`, images, depth, a cloud."""

import contextlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.geometry.lens_forms import fisheye, to_fisheye, to_polynomial, with_lens
from fusion.geometry.pose import Array, inverse, other_axes, transform
from fusion.recording.cameras.over_color import depth_over, fine_as
from fusion.recording.recording import Recording
from fusion.recording.writing.losses import INFRARED, KIND, SCENE, SETTINGS, TELEMETRY, Watched
from fusion.recording.writing.write import depth_counts, tell, write_png

POINTS = 200_000  # of the cloud that splats begin with: as many as colmap's sparse models have, and 3 MB
SAME_PLACE = 1e-6
MOST_PX = 0.2  # that a lens in another form may be off: what the place of a pixel is held to


def fill_nerfstudio(folder: Path, recording: Recording, notes: list[str] | None = None) -> None:
    """A nerfstudio data set into a folder that is being made.

    Depth keeps its counts, and colour images their pixels; where the two are of one place and of other sizes, so are
    the files (nerfstudio brings depth to the colour's size itself). Depth of a camera beside the colour's is brought
    before that, which is told. The cloud is of the depth, in the same world.

    Args:
        recording: with poses and colour images.
        notes: what is to be known about the result is appended here.

    Raises:
        RecordingError: no colour, no poses, a lens that nerfstudio does not know.
    """
    camera = _seen_by(recording)
    apart = _apart(recording)
    measured = recording.camera if apart is None else fine_as(camera, recording.camera)
    poses = recording.poses.at(recording.timestamps).poses if recording.poses is not None else None
    if poses is None or not np.isfinite(poses).any():
        do = "fusion reconstruct finds them; then --poses OUT/trajectory.txt"
        raise RecordingError("there are no poses to write", recording.path, "none", "where the camera stood", do)
    for name in ("images", "depths"):
        (folder / name).mkdir()
    frames, cloud, colors, left = [], [], [], 0
    step = max(1, len(recording) * recording.camera.width * recording.camera.height // POINTS)
    watched = Watched(recording, without=(INFRARED, TELEMETRY, SCENE, SETTINGS, KIND))
    for frame, T_world_camera in zip(watched, poses, strict=True):
        color = recording.color_apart(frame.index) if recording.color_is_apart else frame.color
        if color is None or not np.isfinite(T_world_camera).all():
            left += 1
            continue
        image, depth = f"images/{frame.index:06d}.png", f"depths/{frame.index:06d}.png"
        write_png(folder / image, color)
        over = frame.depth
        if apart is not None:
            over = depth_over(frame.depth, recording.camera, measured, apart)
            T_world_camera = T_world_camera @ inverse(apart)
        write_png(folder / depth, depth_counts(over, recording.camera.depth_scale))
        frames.append({"file_path": image, "depth_file_path": depth, "timestamp": frame.timestamp,
                       "transform_matrix": other_axes(T_world_camera).tolist()})  # fmt: skip
        points, seen = _points(measured, over, camera, color, step)
        cloud.append(transform(T_world_camera, points))
        colors.append(seen)
    if not frames:
        raise RecordingError("there is no frame to write", recording.path, "none with colour and a pose", "one or more")
    told = [] if apart is None else ["depth was brought before the colour camera: between its counts, not one by one"]
    content = _camera_fields(camera, recording.path, told) | {
        "depth_unit_scale_factor": 1 / recording.camera.depth_scale,
        "ply_file_path": "points.ply",
        "frames": frames,
    }
    (folder / "transforms.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    write_cloud(folder / "points.ply", np.concatenate(cloud), np.concatenate(colors))
    told += [
        *recording.warnings,
        *watched.told(),
        *([f"{left} frames without colour or pose are left out"] if left else []),
    ]
    if recording.camera.depth_scale != 1000:
        told.append(f"nerfstudio takes depth for millimetres unless told: --depth-unit-scale-factor "
                    f"{1 / recording.camera.depth_scale:g}")  # fmt: skip
    tell(recording.path, told, notes)


def _seen_by(recording: Recording) -> Camera:
    """The camera of the colour images."""
    has, camera = recording.has_color, recording.camera
    if has is None or not has.any():
        do = "splats are made of colour: record it, or convert to another format"
        raise RecordingError("there are no colour images to write", recording.path, "depth alone", "colour", do)
    return camera.color if recording.color_is_apart and camera.color is not None else camera


def _apart(recording: Recording) -> Array | None:
    """Where the colour camera stands, (4, 4), where that is not the depth camera's place."""
    T = recording.camera.T_color_depth
    return None if not recording.color_is_apart or T is None or np.allclose(T, np.eye(4), atol=SAME_PLACE) else T


def _camera_fields(camera: Camera, where: Path, told: list[str]) -> dict[str, str | float]:
    """The camera as nerfstudio takes it: pixels from the image's corner, half a pixel from the first one's centre.

    It knows three radial terms with tangential ones (the fourth of its form is not undistorted), and OpenCV's fisheye.
    """
    fields: dict[str, str | float] = {"camera_model": "OPENCV", "w": camera.width, "h": camera.height}
    fields |= {"fl_x": camera.fx, "fl_y": camera.fy, "cx": camera.cx + 0.5, "cy": camera.cy + 0.5}
    k1, k2, p1, p2, k3, *more = camera.distortion
    if not any(more):
        return fields | {"k1": k1, "k2": k2, "p1": p1, "p2": p2} | ({"k3": k3} if k3 else {})
    gap, forms = np.inf, dict[str, str | float]()
    with contextlib.suppress(ValueError):
        k = to_polynomial(camera)
        gap = _farthest(camera, replace(camera, distortion=(k[0], k[1], p1, p2, k[2])))
        forms = {"k1": k[0], "k2": k[1], "p1": p1, "p2": p2, "k3": k[2]}
    with contextlib.suppress(ValueError):
        k = to_fisheye(camera)
        if (wide := _farthest(camera, with_lens(camera, fisheye(k))[0])) < gap:
            gap, forms = wide, {"camera_model": "OPENCV_FISHEYE", **dict(zip(("k1", "k2", "k3", "k4"), k, strict=True))}
    if not gap <= MOST_PX:
        found = f"{gap:.2g} px apart" if np.isfinite(gap) else "a lens that does not see all of the image"
        raise RecordingError("nerfstudio does not know this lens", where, found, f"{MOST_PX} px", "pass --camera")
    told.append(f"the lens is written in nerfstudio's form, up to {gap:.2g} px from it")
    return fields | forms


def _farthest(camera: Camera, other: Camera) -> float:
    """How far [px] the rays of a camera's pixels lie apart in the images of the two."""
    rays = camera.rays()[::7, ::7].reshape(-1, 2)
    points = np.column_stack([rays, np.ones(len(rays))])
    return float(np.abs(camera.project(points) - other.project(points)).max())


def _points(
    camera: Camera, depth: NDArray[np.float32], seen_by: Camera, color: NDArray[np.uint8], step: int
) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Every `step`-th point (n, 3) [m] of an image in the camera's frame, and its colour (n, 3)."""
    points = camera.points(depth).reshape(-1, 3)[step // 2 :: step].astype(float)
    points = points[np.isfinite(points[:, 2])]
    u, v = np.rint(seen_by.project(points)).astype(int).T
    inside = (u >= 0) & (u < seen_by.width) & (v >= 0) & (v < seen_by.height)
    return points[inside], color[v[inside], u[inside]]


def write_cloud(path: Path, points: NDArray[np.floating], colors: NDArray[np.uint8]) -> None:
    """A PLY of points (n, 3) [m] with colours (n, 3) RGB."""
    fields = [(name, "<f4") for name in "xyz"] + [(name, "u1") for name in ("red", "green", "blue")]
    rows = np.empty(len(points), fields)
    for k, (name, _) in enumerate(fields):
        rows[name] = (points if k < 3 else colors)[:, k % 3]
    kinds = [("float" if k < 3 else "uchar", name) for k, (name, _) in enumerate(fields)]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    head += [f"property {kind} {name}" for kind, name in kinds] + ["end_header\n"]
    path.write_bytes("\n".join(head).encode() + rows.tobytes())
