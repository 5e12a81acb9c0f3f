"""A `.xef` of this judge read by KinectXEFTools (C#, by Mono): every event must come out as it was written.

SOURCES: a checkout of github Isaac-W/KinectXEFTools. Debian's mono-mcs and mono-runtime are needed.
"""

import hashlib
import os
import subprocess
from pathlib import Path

from tools.formats.take import Take
from tools.formats.writers import xef

PROGRAM = Path(__file__).with_name("xef_dump.cs")
PARTS = ("IEventReader", "XEFEvent", "XEFEventReader", "XEFStream", "XEFUtil")


def write(take: Take, path: Path, sources: Path | None, archived: bool = False, color: bool = False) -> Path:
    """The recording, once that reader has agreed; `sources` None: nobody is asked. Raises ValueError."""
    out = xef.write(take, path, archived, color)
    if sources is None:
        return out
    wanted = [
        (xef.STREAMS[index][0], str(frame), str(tick), hashlib.md5(held, usedforsecurity=False).hexdigest())
        for index, tick, frame, held in xef.events(take, color)
    ]
    seen = [one for one in read(out, sources) if one[0] != "Properties"]
    if sorted(seen) != sorted(wanted) or (not archived and seen != wanted):
        raise ValueError(f"KinectXEFTools reads {len(seen)} events of {out} where {len(wanted)} others were written")
    return out


def read(path: Path, sources: Path) -> list[tuple[str, ...]]:
    """Stream, frame, tick and MD5 of each event, in the order of that reader."""
    built = path.with_suffix(".exe")
    parts = [str(next(sources.rglob(f"{name}.cs"))) for name in PARTS]
    call = ["mcs", "-nowarn:219,414", f"-out:{built}", str(PROGRAM), *parts]
    subprocess.run(call, check=True, capture_output=True)
    env = os.environ | {"MONO_TRACE_LISTENER": "Console.Error"}
    done = subprocess.run(["mono", str(built), str(path)], check=True, capture_output=True, text=True, env=env)
    return [tuple(line.split("\t")) for line in done.stdout.splitlines()]
