"""Where the foreign writers live, and how they are called."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Tools:
    """Interpreters with pyrealsense2 2.56 and 2.58 or later and with mcap-ros2-support; the folders of libk4a,
    OpenNI2, ScanNet and KinectXEFTools; Debian's rosbag, unpacked; a word that rows have in their names."""

    bag: Path | None = None
    db3: Path | None = None
    mcap: Path | None = None
    k4a: Path | None = None
    oni: Path | None = None
    sens: Path | None = None
    rosbag: Path | None = None
    only: str = ""
    xef: Path | None = None


def elsewhere(python: Path | None, program: str, take: Path, out: Path, *words: str) -> Path:
    """Run a writer of this folder by another interpreter."""
    if python is None:
        raise FileNotFoundError(f"{program} wants an environment of its own: see tools/formats/judge.py")
    subprocess.run([str(python), str(HERE / program), str(take), str(out), *words], check=True)
    return out


def by_debian(root: Path, program: str, take: Path, out: Path, *words: str) -> Path:
    """Run a writer of this folder by the system's Python, with Debian's packages that were unpacked into `root`."""
    libraries = root / "usr/lib/x86_64-linux-gnu"
    paths = ":".join(str(libraries / name) for name in ("", "blas", "lapack"))
    env = {"PYTHONPATH": str(root / "usr/lib/python3/dist-packages"), "LD_LIBRARY_PATH": paths}
    subprocess.run(["/usr/bin/python3", str(HERE / program), str(take), str(out), *words], check=True, env=env)
    return out
