"""Phones' recordings, from their makers' descriptions: zip archives with LZFSE (Apple's code, by the library lzfse),
PNG and JPEG by OpenCV, video by av.

ARKit: poses have x right, y up and look along -z; the principal point is counted from the image's corner.
"""

import json
import zipfile
from pathlib import Path

import cv2
import numpy as np

from tools.formats.folders import quaternion
from tools.formats.take import Array, Take

ARKIT = np.diag([1.0, -1, -1, 1])
TIMES = 4  # the picture is so many times as wide as the depth, as in LiDAR phones (1920 to 256 is 7.5)


def jpeg(pixels: np.ndarray, quality: int = 90) -> bytes:
    """RGB as JPEG."""
    turned = np.ascontiguousarray(pixels[..., ::-1])
    return cv2.imencode(".jpg", turned, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def larger(take: Take, times: int) -> tuple[float, float, float, float]:
    """fx, fy, and the principal point from the corner, of a picture `times` as wide: borders stay where they are."""
    fx, fy, cx, cy = take.lens.four
    return fx * times, fy * times, (cx + 0.5) * times, (cy + 0.5) * times


def poses(take: Take) -> Array:
    """(n, 4, 4) in ARKit's axes; a still camera stands at the origin."""
    stated = np.repeat(np.eye(4)[None], len(take.stamps), axis=0) if take.poses is None else take.poses
    return np.asarray(stated @ ARKIT)


def record3d(take: Take, path: Path, times: int = 1) -> Path:
    """`.r3d`: K by columns, poses qx qy qz qw tx ty tz, depth float32 metres (github record3d#93, #86, #83)."""
    import lzfse

    fx, fy, ox, oy = larger(take, times)
    h, w = take.depth.shape[1:]
    rows = [[*quaternion(T), *T[:3, 3]] for T in poses(take)]
    told = {"w": w * times, "h": h * times, "dw": w, "dh": h, "fps": 30, "K": [fx, 0, 0, 0, fy, 0, ox, oy, 1]}
    told |= {"perFrameIntrinsicCoeffs": [[fx, fy, ox, oy]] * len(rows), "poses": [list(map(float, r)) for r in rows]}
    told |= {"frameTimestamps": take.stamps.tolist(), "initPose": [0, 0, 0, 1, 0, 0, 0]}
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("metadata", json.dumps(told))
        sure = lzfse.compress(np.full((h, w), 2, np.uint8).tobytes())
        packed = [lzfse.compress(np.where(z > 0, z, np.nan).astype("<f4").tobytes()) for z in take.depth]
        for i in range(len(rows)):
            archive.writestr(f"rgbd/{i}.depth", packed[i % len(packed)])
            archive.writestr(f"rgbd/{i}.conf", sure)
            if take.color is not None:
                archive.writestr(f"rgbd/{i}.jpg", jpeg(enlarged(take.color[i], times)))
    return path


def enlarged(pixels: np.ndarray, times: int) -> np.ndarray:
    """The same picture with `times` as many columns and rows."""
    return pixels if times == 1 else cv2.resize(pixels, None, fx=times, fy=times, interpolation=cv2.INTER_LINEAR)


def polycam(take: Take, path: Path) -> Path:
    """Polycam's raw data (github PolyCam/polyform): names are microseconds, depth millimetres, t_rc camera to world."""
    fx, fy, ox, oy = larger(take, TIMES)
    h, w = take.depth.shape[1:]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for i, (counts, T) in enumerate(zip(take.counts(0.001), poses(take), strict=True)):
            name = str(round(take.stamps[i] * 1e6))
            camera = {f"t_{r}{c}": float(T[r, c]) for r in range(3) for c in range(4)}
            camera |= {"fx": fx, "fy": fy, "cx": ox, "cy": oy, "width": w * TIMES, "height": h * TIMES}
            archive.writestr(f"keyframes/corrected_cameras/{name}.json", json.dumps(camera))
            archive.writestr(f"keyframes/depth/{name}.png", png(counts))
            archive.writestr(f"keyframes/confidence/{name}.png", png(np.full((h, w), 255, np.uint8)))  # 255 is sure
            if take.color is not None:
                archive.writestr(f"keyframes/corrected_images/{name}.jpg", jpeg(enlarged(take.color[i], TIMES)))
    return path


def png(pixels: np.ndarray) -> bytes:
    """As PNG."""
    return cv2.imencode(".png", pixels)[1].tobytes()


def stray(take: Take, path: Path) -> Path:
    """Stray Scanner (docs.strayrobots.io, scanner's format): 256 x 192 beside a video of 1920 x 1440."""
    (path / "depth").mkdir(parents=True)
    (path / "confidence").mkdir()
    h, w = take.depth.shape[1:]
    times = 1920 / w
    fx, fy, cx, cy = take.lens.four
    K = [[fx * times, 0, (cx + 0.5) * times], [0, fy * times, (cy + 0.5) * times], [0, 0, 1]]
    np.savetxt(path / "camera_matrix.csv", np.array(K), delimiter=", ", fmt="%.9f")
    rows = ["timestamp, frame, x, y, z, qx, qy, qz, qw"]
    assert take.poses is not None
    for i, (counts, T) in enumerate(zip(take.counts(0.001), take.poses, strict=True)):
        cv2.imwrite(str(path / "depth" / f"{i:06d}.png"), counts)
        cv2.imwrite(str(path / "confidence" / f"{i:06d}.png"), np.full((h, w), 2, np.uint8))
        values = ", ".join(f"{v:.9f}" for v in [*T[:3, 3], *quaternion(T)])
        rows.append(f"{take.stamps[i]:.6f}, {i:06d}, {values}")
    (path / "odometry.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    if take.color is not None:
        video(path / "rgb.mp4", [cv2.resize(one, (1920, 1440)) for one in take.color])
    return path


def video(path: Path, pictures: list[np.ndarray]) -> None:
    """H.264 or what av has."""
    import av

    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = pictures[0].shape[1], pictures[0].shape[0], "yuv420p"
        for one in pictures:
            for packet in stream.encode(av.VideoFrame.from_ndarray(one, format="rgb24")):
                container.mux(packet)
        for packet in stream.encode():
            container.mux(packet)
