"""A live scan from its first frame to its recording: recorder, view and whoever looks on."""

import contextvars
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, suppress
from pathlib import Path

from fusion.devices.record import Recorded, RecordSettings, fill_recorded
from fusion.devices.source import Source
from fusion.live.aside import Aside
from fusion.live.feed import Feed
from fusion.live.looking import every
from fusion.live.ready import get_ready
from fusion.live.struck import strike
from fusion.live.watch import Watch
from fusion.progress import stage

SAID = 1.0  # [s] between two lines on the terminal
PATIENCE = 5.0  # [s] that the view may take to its end
Shown = Callable[[Feed, Watch], AbstractContextManager[None]]  # a page, while the block runs


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
        settings: of the recording.
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
