# mypy: ignore-errors
"""CloudCompare's command line, signed; its own clock, as reading and writing files is no part of the work."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from common import answer, load

root = Path(sys.argv[2]).resolve().parent / "debian-cloudcompare"  # see `environments.unpacked`
libraries = next(root.glob("usr/lib/*/cloudcompare")).parent
environment = os.environ | {
    "LD_LIBRARY_PATH": f"{libraries}:{libraries / 'cloudcompare'}",
    "QT_PLUGIN_PATH": str(libraries / "qt5" / "plugins"),
    "QT_QPA_PLATFORM": "offscreen",
}


def write(path, points, faces=()):
    """Binary PLY in double precision."""
    triangles = np.empty(len(faces), [("corners", "u1"), ("vertices", "<i4", 3)])
    if len(faces):
        triangles["corners"], triangles["vertices"] = 3, faces
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"] if len(faces) else []
    head = "\n".join([*lines, "end_header", ""])
    path.write_bytes(head.encode() + points.astype("<f8").tobytes() + triangles.tobytes())


w = load()
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    write(folder / "points.ply", w.points)
    write(folder / "mesh.ply", w.vertices, w.faces)
    command = [root / "usr/bin/CloudCompare", "-SILENT", "-NO_TIMESTAMP", "-AUTO_SAVE", "OFF", "-LOG_FILE", "log.txt"]
    command += ["-O", "points.ply", "-O", "mesh.ply", "-C2M_DIST"]
    command += ["-C_EXPORT_FMT", "ASC", "-PREC", "9", "-SAVE_CLOUDS"]
    subprocess.run([str(c) for c in command], cwd=folder, env=environment, check=True, capture_output=True, timeout=300)
    spent = re.findall(r"ompute(?:Approx)?Distances\] Time: ([\d.]+)", (folder / "log.txt").read_text())
    written = next(folder.glob("points_*.asc"))
    found = np.array([line.rsplit(maxsplit=1)[1] for line in written.read_text().splitlines()], float)
answer(times={"distances": [sum(map(float, spent))]}, mean_um=float(np.abs(found).mean() * 1e6), signed=True)
