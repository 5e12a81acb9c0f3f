"""The readers of recordings, judged by files that others' programs write: sizes, places, clocks, meshes, rates.

    python -m tools.formats.judge turn -o OUT        one turn through five formats, the meshes beside native's
    python -m tools.formats.judge scenes -o OUT      size, place and hand of a scene of known size through every format
    python -m tools.formats.judge long -o OUT        20 000 frames: seconds to open, memory
    python -m tools.formats.judge commands -o OUT    reconstruct, turntable and convert, once for each format
    python -m tools.formats.judge told -o OUT        dropped frames, clock jumps and settings: what `fusion info` tells

Other hands' writers live in environments of their own, named by options:
    python3 -m venv A; A/bin/pip install numpy pyrealsense2==2.56.5.9235     --bag A/bin/python
    python3 -m venv B; B/bin/pip install numpy pyrealsense2==2.59.1.11053    --db3 B/bin/python
    python3 -m venv C; C/bin/pip install numpy mcap-ros2-support==0.6.0      --mcap C/bin/python
    pip download --no-deps pyk4a-bundle==1.5.0; python -m zipfile -e *.whl K  --k4a K
    apt-get download libopenni2-0 libopenni2-dev; dpkg -x each R              --oni R     (and g++)
    apt-get -y --download-only -o Dir::Cache::archives=D install python3-rosbag python3-tf2-msgs python3-sensor-msgs
        python3-geometry-msgs python3-numpy; dpkg -x each R                   --rosbag R
    git clone https://github.com/ScanNet/ScanNet S                            --sens S    (and g++)
    git clone https://github.com/Isaac-W/KinectXEFTools X                     --xef X     (and mono-mcs, mono-runtime)
The project's own environment needs `.[dev]`. tools/formats shares no code with the program's readers.
"""

import argparse
import json
import os
import sys
from dataclasses import asdict
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

from tools.formats import commands, long, scenes, told, turn
from tools.formats.writers.programs import Tools

PARTS = {"turn": turn, "scenes": scenes, "long": long, "commands": commands, "told": told}


def main() -> int:
    """Run one part, print its table and write it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=list(PARTS))
    for name in ("bag", "db3", "mcap", "k4a", "oni", "sens", "rosbag", "xef"):
        parser.add_argument(f"--{name}", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="rows whose name has this word; default: all")
    parser.add_argument("-o", "--output", type=Path, required=True)
    said = parser.parse_args()
    part = PARTS[said.part]
    rows = part.judged(
        Tools(said.bag, said.db3, said.mcap, said.k4a, said.oni, said.sens, said.rosbag, said.only, said.xef),
        said.output / said.part,
        said.seed,
    )
    table = [part.HEAD, *map(part.line, rows)]
    print("\n".join(table))
    (said.output / f"{said.part}.txt").write_text("\n".join([*table, ""]), encoding="utf-8")
    (said.output / f"{said.part}.json").write_text(json.dumps([asdict(r) for r in rows], indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
