"""Small good recordings as other programs write them: 7-Scenes, BOP, fakenect, Open3D, plain TUM, and of phones."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from broken import bases, pictures

Build = Callable[[Path], object]


UNIT = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"


def seven_scenes(rec: Path) -> None:
    """As the data set's page tells: three files a frame, depth in millimetres, poses camera to world."""
    rec.mkdir()
    for n in range(3):
        (rec / f"frame-{n:06d}.depth.png").write_bytes(pictures.png(bases.depth_counts("wall", n)))
        (rec / f"frame-{n:06d}.pose.txt").write_text(UNIT, encoding="ascii")


def bop(rec: Path) -> None:
    """As bop_toolkit's docs/bop_datasets_format.md tells: depth_scale takes counts to millimetres."""
    (rec / "depth").mkdir(parents=True)
    for n in range(3):
        (rec / "depth" / f"{n:06d}.png").write_bytes(pictures.png(bases.depth_counts("wall", n)))
    bases.write_json(rec / "scene_camera.json", bop_cameras())


def bop_cameras() -> dict:
    return {str(n): {"cam_K": [144, 0, 79.5, 0, 144, 59.5, 0, 0, 1], "depth_scale": 1.0} for n in range(3)}


def fakenect(rec: Path) -> None:
    """As OpenKinect's fakenect-record leaves them: an index, and 640 x 480 pictures of 11 or 16 bits as PGM."""
    rec.mkdir()
    names = [f"d-{1306361010 + n}.25-{3408212745 + 2000000 * n}.pgm" for n in range(3)]
    counts = np.full((480, 640), 700, "<u2")
    for name in names:
        (rec / name).write_bytes(b"P5 640 480 65535\n" + counts.tobytes())
    (rec / "INDEX.txt").write_text("\n".join(names) + "\n", encoding="ascii")


def open3d(rec: Path) -> None:
    """As Open3D's reconstruction system takes it: depth/, color/, the matrix column by column."""
    for kind in ("depth", "color"):
        (rec / kind).mkdir(parents=True)
    for n in range(3):
        (rec / "depth" / f"{n:06d}.png").write_bytes(pictures.png(bases.depth_counts("wall", n)))
        (rec / "color" / f"{n:06d}.png").write_bytes(pictures.png(np.full((120, 160, 3), 80, np.uint8), 2))
    bases.write_json(rec / "intrinsic.json", intrinsic())


def intrinsic() -> dict:
    return {"width": 160, "height": 120, "intrinsic_matrix": [144, 0, 0, 0, 144, 0, 79.5, 59.5, 1]}


def tum(rec: Path) -> None:
    """Without camera.json."""
    bases.recording(rec.parent, rec.name)
    (rec / "camera.json").unlink()


def nerfstudio(rec: Path) -> None:
    """As docs.nerf.studio's data conventions tell: OpenGL's axes, depth in millimetres."""
    (rec / "depths").mkdir(parents=True)
    for n in range(3):
        (rec / "depths" / f"{n}.png").write_bytes(pictures.png(bases.depth_counts("wall", n)))
    bases.write_json(rec / "transforms.json", transforms())


def transforms() -> dict:
    pose = [[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    frames = [{"file_path": f"images/{n}.png", "depth_file_path": f"depths/{n}.png", "transform_matrix": pose}
              for n in range(3)]  # fmt: skip
    return {"fl_x": 144.0, "fl_y": 144.0, "cx": 80.0, "cy": 60.0, "w": 160, "h": 120, "frames": frames}


def stray(rec: Path) -> None:
    """As docs.strayrobots.io tells: millimetres, a matrix of the 1920 x 1440 video, a table of poses."""
    (rec / "depth").mkdir(parents=True)
    for n in range(3):
        (rec / "depth" / f"{n:06d}.png").write_bytes(pictures.png(bases.depth_counts("wall", n)))
    (rec / "camera_matrix.csv").write_text("1728, 0, 960\n0, 1728, 720\n0, 0, 1\n", encoding="ascii")
    (rec / "odometry.csv").write_text(odometry(), encoding="ascii")


def freenect2(rec: Path) -> None:
    """As programs on libfreenect2 write a frame's memory: 512 x 424 float32 millimetres, nothing else."""
    rec.mkdir()
    for n in range(3):
        (rec / f"{n}.bin").write_bytes(np.full((424, 512), 1200 + n, "<f4").tobytes())


def odometry() -> str:
    rows = [f"{10 + n / 30:.6f}, {n:06d}, 0, 0, 0, 0, 0, 0, 1" for n in range(3)]
    return "\n".join(["timestamp, frame, x, y, z, qx, qy, qz, qw", *rows]) + "\n"
