"""What is recognised and not read: said by name, with what to do instead."""

import re
import sqlite3
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.reading import beginning

SQLITE = b"SQLite format 3\0"
# how files begin: what it is, what to do. The first that fits counts
_BEGINNINGS: tuple[tuple[bytes, str, str], ...] = (
    (
        rb"\x1aE\xdf\xa3",
        "a Matroska video without Azure Kinect's depth",
        "a recording needs depth: export that with it",
    ),
    (rb"\x28\xb5\x2f\xfd", "a file packed by zstd", "unpack it: zstd -d FILE"),
    (rb"\x1f\x8b", "a file packed by gzip", "unpack it first"),
    (rb"PK\x03\x04", "a zip archive of no known recording", "unpack it and open the recording's folder"),
    (rb"....ftyp", "a video (MP4, MOV)", "a recording needs depth: export that with it"),
    (rb"\x89PNG|\xff\xd8\xff", "one picture", "name the folder of the whole recording"),
    (rb"ply\r?\n|solid |glTF|# \.PCD|ASTM-E57", "a mesh or a cloud", "fusion compare and fusion convert read it"),
)
# its own depth maps have the size of its poses, which pictures alone do not tell
_COLMAP = (
    "it holds no metric depth: open the recording that the pictures came from, or export nerfstudio's transforms.json "
    "(ns-process-data images --skip-colmap), in metres, and name a depth camera's image in each frame's depth_file_path"
)
# tables that tell whose a database is
_TABLES: tuple[tuple[frozenset[str], str, str], ...] = (
    (
        frozenset({"node", "data", "link"}),
        "an RTAB-Map database",
        # 10: time stamp, place, quaternion, as in TUM's files; the default has a number behind them
        "export it: rtabmap-export --images --poses_camera --poses_format 10 FILE, and open its ..._depth (--camera: "
        "the numbers of ..._calib; --poses ..._camera_poses.txt)",
    ),
    (
        frozenset({"cameras", "images", "keypoints"}),
        "a COLMAP database",
        _COLMAP,
    ),
)
KINECT_V2_RAW = 10 * 298_496  # bytes: the ten pictures that make one depth image, as they come over USB
_SCANNERS = (".fix_prj", ".hand_prj", ".rap_prj", ".sproj", ".a3d", ".revo")  # EinScan, Artec, Revopoint


def refusal(path: Path) -> RecordingError | None:
    """What a file or folder is, where it is known and cannot be opened; None where it is not known."""
    what, do = _folder(path) if path.is_dir() else _file(path)
    return RecordingError(f"{what} cannot be opened as a recording", path, do=do) if what else None


def tables(path: Path) -> set[str]:
    """Names of an SQLite file's tables, in small letters; none where it cannot be read."""
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)) as base:
            rows = base.execute("SELECT name FROM sqlite_master WHERE type = 'table' LIMIT 1000").fetchall()
    except (sqlite3.Error, OSError, ValueError):
        return set()
    return {str(name).lower() for (name,) in rows}


def _file(path: Path) -> tuple[str, str]:
    start = beginning(path)
    if start.startswith(SQLITE):
        held = tables(path)
        found = next(((what, do) for needed, what, do in _TABLES if needed <= held), None)
        return found or ("an SQLite database of no known recording", "")
    found = next(((what, do) for begin, what, do in _BEGINNINGS if re.match(begin, start, re.DOTALL)), None)
    return found or _project([path.name])


def _folder(path: Path) -> tuple[str, str]:
    names = {entry.name.lower() for entry in path.iterdir()}
    # the model itself, the project that holds it, or one whose model has a number, as COLMAP's own mapper makes them
    if any(map(_colmap_model, (path, path / "0", path / "sparse", path / "sparse" / "0"))):
        return "a COLMAP model", _COLMAP
    packets = (entry for entry in path.iterdir() if entry.suffix == ".depth" and entry.is_file())
    if any(entry.stat().st_size == KINECT_V2_RAW for entry in packets):
        return (
            "a folder of raw Kinect v2 packets (libfreenect2)",
            "its tables are not in it: record depth as 16-bit PNG",
        )
    return _project(names)


def _colmap_model(folder: Path) -> bool:
    names = {entry.name.lower() for entry in folder.iterdir()} if folder.is_dir() else set()
    return any({f"{part}.{end}" for part in ("cameras", "images", "points3d")} <= names for end in ("bin", "txt"))


def _project(names: Iterable[str]) -> tuple[str, str]:
    if any(name.lower().endswith(_SCANNERS) for name in names):
        return "a hand scanner's own project", "export a mesh or a cloud (PLY, STL, OBJ): fusion compare reads those"
    return "", ""
