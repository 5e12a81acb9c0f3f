"""A live scan from its first frame to its recording: recorder, view and whoever looks on."""

import contextvars
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, suppress
from pathlib import Path

import numpy as np

from fusion.devices.record import Recorded, RecordSettings, fill_recorded
from fusion.devices.source import Source, SourceFrame
from fusion.files.output.publish import atomic_file
from fusion.files.reading import read_text
from fusion.geometry.camera import Camera
from fusion.live.aside import Aside
from fusion.live.feed import Feed
from fusion.live.grow import Grower
from fusion.live.looking import SURE, every
from fusion.live.watch import Watch
from fusion.progress import stage
from fusion.recording.writing.write import LISTS
from fusion.turntable.views import Region

SAID = 1.0  # [s] between two lines on the terminal
PATIENCE = 5.0  # [s] that the view may take to its end
Shown = Callable[[Feed, Watch], AbstractContextManager[None]]  # a page, while the block runs
DISTANCE, SIZE = 0.7, 0.2  # [m] of a ball that nobody sees
ASIDE = "undone.txt"  # which stamps were taken back


def record_live(
    source: Source,
    path: Path,
    place: Callable[[], AbstractContextManager[Path]],
    settings: RecordSettings,
    shown: Shown | None = None,
) -> tuple[Recorded, Watch]:
    """Record a source while its object is tracked and fused, until it ends, a person says so, or Ctrl-C.

    Args:
        path, place: as `fill_recorded` takes them.
        shown: a view; None: a line of text.

    Raises:
        DeviceError: no frame came, or the device went away; what was recorded before stays.
    """
    feed, over = Feed(source), threading.Event()
    with ExitStack() as stack:
        beside = stack.enter_context(Aside())
        beside.submit(every, source.describe().camera, 1)  # loads what a look needs before the first frame comes
        with stage("getting ready"), suppress(Exception):  # what goes wrong the view will meet itself, and tell
            get_ready(source.describe().camera)
        watch = Watch(feed, path.parent, beside)
        if shown is not None:
            stack.enter_context(shown(feed, watch))
        watch.start()
        around = contextvars.copy_context()
        line = threading.Thread(target=around.run, args=(_say, watch, over), daemon=True)
        line.start()
        try:
            done = fill_recorded(feed, path, place, settings)
        finally:
            over.set()
            line.join()
        watch.join(PATIENCE)
        if watch.struck:
            strike(path, watch.struck)
    return done, watch


def _say(watch: Watch, over: threading.Event) -> None:
    while not over.wait(SAID):
        with stage(watch.shown.line()):
            over.wait(SAID)


def get_ready(camera: Camera) -> None:
    """Let a view of its own take two frames of a ball before this camera, and show what it made."""
    grower = Grower(camera)
    middle = np.array([0.0, 0.0, DISTANCE])
    grower.looking.region, grower.looking.finds = Region(middle - SIZE, middle + SIZE), SURE
    v, u = np.mgrid[: camera.height, : camera.width]
    across, down = (u - camera.width / 2) * DISTANCE / camera.fx, (v - camera.height / 2) * DISTANCE / camera.fy
    height = SIZE**2 / 4 - across**2 - down**2
    depth = np.where(height > 0, DISTANCE - np.sqrt(np.maximum(height, 0)), np.nan).astype(np.float32)
    for index in range(2):
        grower.take(SourceFrame(index, index / 30, depth))
    grower.surface()


def strike(folder: Path, spans: list[tuple[float, float]]) -> int:
    """Take the frames of some spans of time (after, up to and without) [s] out of a recording's lists; how many.

    `undone.txt` names their stamps and images.
    """
    aside = []
    for name in LISTS:
        path = folder / f"{name}.txt"
        if path.exists():
            lines = read_text(path).splitlines(keepends=True)
            gone = [line for line in lines if _taken_back(line, spans)]
            with atomic_file(path) as made:
                made.write_text("".join(line for line in lines if line not in gone), encoding="utf-8")
            aside += gone
    (folder / ASIDE).write_text("# timestamp filename\n" + "".join(aside), encoding="utf-8")
    return sum(" depth/" in line for line in aside)


def _taken_back(line: str, spans: list[tuple[float, float]]) -> bool:
    if line.startswith("#"):
        return False
    stamp = float(line.split()[0])
    return any(after + 1e-6 < stamp < until - 1e-6 for after, until in spans)
