"""Measures README's figures that take minutes again, and writes what was printed into docs/measured.md.

    python -m tools.reproduce.figures [--only box ...]    some 10 minutes on two cores; `make figures`

Each command runs in a process of its own; its words are kept as they are, with its wall time. A command that fails ends
all, and the page stays as it was. Figures that take longer are in README with their commands.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

from fusion.files.output.publish import atomic_file

PROJECT = Path(__file__).resolve().parents[2]
PAGE = PROJECT / "docs" / "measured.md"
SCANS = "tools.reproduce.scans"
# what README calls it, and the command's words after `python -m`
FIGURES = {
    "objects": ("Three objects, one view, against their scanner meshes", f"{SCANS}.ycbv_surface"),
    "hand-held": ("A hand-held Kinect v1, 120 frames, against motion capture", f"{SCANS}.tum_trajectory"),
    "box": ("A real cardboard box on a turntable, nominal camera, no option", f"{SCANS}.kleenex_turntable"),
    "by hand": ("A printed box turned by hand before a wall, no hint", f"{SCANS}.custard_box"),
    "statue": ("A statue on a simulated table", f"{SCANS}.turntable_challenge --case turntable_v1_statue"),
    "sensors": ("Fankhauser's table II", "tools.reproduce.fankhauser --only table"),
}
HEAD = """# Figures as they were measured last

Written by `make figures` (`python -m tools.reproduce.figures`): what each command printed, and how long it took beside
whatever else the machine did. The [README](../README.md#figures) says what the figures mean, and names the commands of
those that take longer.
"""


def main() -> None:
    """Run all, then write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(FIGURES), help="print these and write nothing")
    only = parser.parse_args().only
    parts = [measured(*FIGURES[name]) for name in only or FIGURES]
    if only:
        print(*parts, sep="\n")
        return
    with atomic_file(PAGE) as partial:
        partial.write_text("\n".join([HEAD, *parts]), encoding="utf-8")


def measured(title: str, command: str) -> str:
    """A part of the page."""
    begin = time.monotonic()
    words = [sys.executable, "-m", *command.split()]
    done = subprocess.run(words, cwd=PROJECT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"error: python -m {command}: {done.stderr.strip()[-500:]}")
    took = f"`python -m {command}`, {time.monotonic() - begin:.0f} s:"
    return f"## {title}\n\n{took}\n\n```text\n{done.stdout.rstrip()}\n```\n"


if __name__ == "__main__":
    main()
