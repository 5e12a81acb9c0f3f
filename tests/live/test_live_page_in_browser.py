"""The page of a live scan in a browser: its buttons do what they say, and whatever becomes of it stops nothing."""

import io
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "report"))
from browser import BINARY, Browser
from rounds import Rounds

from fusion.commands.main import main
from fusion.devices.record import Recorded, RecordSettings
from fusion.files.output.publish import output_folder
from fusion.live import page as pages
from fusion.live.session import record_live
from fusion.live.watch import Watch
from fusion.recording.open import open_recording

pytestmark = [pytest.mark.slow, pytest.mark.skipif(BINARY is None, reason="no Chromium is installed")]
CAMERA = {"width": 160, "height": 120, "fx": 144, "fy": 144, "cx": 79.5, "cy": 59.5, "depth_scale": 5000}
RATE = 10.0  # frames a second: what a busy machine still keeps up with
TEXT = "document.body.innerText"
BUTTONS = "[...document.querySelectorAll('button')]"


@pytest.fixture(scope="module", autouse=True)
def _viser():
    pytest.importorskip("viser", reason="viser, of the extra live, is not installed")


@pytest.fixture(scope="module")
def turn(tmp_path_factory):
    """A whole turn of the demo's object."""
    folder = tmp_path_factory.mktemp("turn")
    (folder / "camera.json").write_text(json.dumps(CAMERA | {"principle": "structured_light"}))
    words = f"--set frames=60 --set turns=1 --camera {folder}/camera.json --seed 3 --quiet"
    assert main(["simulate", "turntable", *words.split(), "-o", str(folder / "turn")]) == 0
    return open_recording(folder / "turn")


def free_port() -> int:
    with socket.socket() as tried:
        tried.bind(("127.0.0.1", 0))
        return tried.getsockname()[1]


class Scan:
    """A live scan with its page, in a thread."""

    def __init__(self, source: Rounds, folder: Path) -> None:
        self.source, self.path, self.port = source, folder / "rec", free_port()
        self.done: Recorded | None = None
        self.watch: Watch | None = None
        self.feed = None
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self) -> None:
        def shown(feed, watch):
            self.feed, self.watch = feed, watch
            return pages.page(self.port, feed, watch)

        place = partial(output_folder, self.path)
        with self.source:
            self.done, _ = record_live(self.source, self.path, place, RecordSettings(), shown)

    def __enter__(self) -> "Scan":
        until(lambda: not self.thread.is_alive() or (self.watch is not None and self.watch.tracked > 5))
        assert self.thread.is_alive(), self.watch and (self.watch.error, self.watch.shown.line())
        return self

    def __exit__(self, *what: object) -> None:
        self.source.stop()
        self.thread.join(30)

    def ended(self, within: float = 30.0) -> Recorded:
        self.thread.join(within)
        assert not self.thread.is_alive()
        assert self.done is not None
        assert self.watch is not None
        assert self.watch.error is None
        return self.done


def until(true, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


def click(browser: Browser, name: str) -> None:
    """As a person does: where the button is, if nothing lies over it."""
    box = browser.evaluate(
        f"(() => {{const b = {BUTTONS}.find(e => e.innerText.trim().startsWith({name!r})); "
        "b.scrollIntoView({block: 'center', behavior: 'instant'}); const r = b.getBoundingClientRect(); "
        "const x = r.x + r.width / 2, y = r.y + r.height / 2; "
        "return {x, y, free: b.contains(document.elementFromPoint(x, y))}})()"
    )
    assert box["free"], f"{name} lies under something, or outside of the window"
    for kind in ("mousePressed", "mouseReleased"):
        browser._call("Input.dispatchMouseEvent", type=kind, x=box["x"], y=box["y"], button="left", clickCount=1)


def complaints(browser: Browser) -> list[str]:
    """What the console holds, but what viser's own library says of itself, which is a warning."""
    return [said for said in browser.console if not said.startswith("THREE.Clock: This module has been deprecated")]


def looked_at(browser: Browser, name: str) -> np.ndarray:
    """The window as (h, w, 3); kept where FUSION_PICTURES names a folder."""
    data = browser.screenshot()
    if folder := os.environ.get("FUSION_PICTURES"):
        (Path(folder) / f"{name}.png").write_bytes(data)
    return cv2.imdecode(np.frombuffer(io.BytesIO(data).read(), np.uint8), cv2.IMREAD_COLOR)


def green(picture: np.ndarray) -> int:
    """Pixels of a BGR picture that are: nothing else in the middle of the window is."""
    b, g, r = np.moveaxis(picture.astype(int), -1, 0)
    return int(((g > b + 40) & (g > r)).sum())


def opened(browser: Browser, scan: Scan) -> None:
    browser.open(f"http://127.0.0.1:{scan.port}/")
    assert browser.wait_for(f"{TEXT}.includes('tracking')", 60)


def test_every_button_does_what_it_says(turn, tmp_path):
    source = Rounds(turn, RATE)
    with Scan(source, tmp_path) as scan, Browser(1280, 900) as browser:
        opened(browser, scan)
        assert browser.wait_for(f"{TEXT}.includes('tracking good')", 60)
        click(browser, "Pause")
        until(lambda: scan.feed.paused)
        assert browser.wait_for(f"{TEXT}.includes('paused')")
        recorded, given = scan.feed.recorded, source.given
        time.sleep(1.0)
        assert scan.feed.recorded <= recorded + 1
        assert source.given > given + 3  # the camera runs on
        click(browser, "Start")
        until(lambda: scan.feed.recorded > recorded + 5)
        assert browser.wait_for(f"{TEXT}.includes('scanning')")
        until(lambda: scan.watch.grower.count > 45)
        click(browser, "Undo")
        until(lambda: scan.watch.struck)
        (after, before) = scan.watch.struck[0]
        assert before - after >= 30 / RATE - 0.5
        browser.evaluate("document.querySelector('[role=slider]').focus()")
        for kind in ("keyDown", "keyUp"):
            browser._call(
                "Input.dispatchKeyEvent", type=kind, key="ArrowRight", code="ArrowRight", windowsVirtualKeyCode=39
            )
        until(lambda: source.motor.tilted)
        assert source.motor.tilted[-1] == 1.0
        # the surface is there in its colours of how sure, soon after much of it was taken back
        until(lambda: green(looked_at(browser, "live")[200:700, 200:800]) > 500)
        assert complaints(browser) == []
        click(browser, "Finish")
        done = scan.ended()
    assert done.frames == scan.feed.recorded
    assert len(open_recording(scan.path)) <= done.frames - 25  # without those that were taken back
    assert (scan.path / "undone.txt").exists()


def test_it_can_be_used_on_a_phone(turn, tmp_path):
    with Scan(Rounds(turn, RATE), tmp_path) as scan, Browser(390, 844) as browser:
        opened(browser, scan)
        assert browser.wait_for(f"{TEXT}.includes('tracking good')", 60)
        time.sleep(1.0)
        looked_at(browser, "phone")
        assert browser.evaluate("document.documentElement.scrollWidth") <= 390
        click(browser, "Pause")
        until(lambda: scan.feed.paused)
        click(browser, "Start")
        until(lambda: not scan.feed.paused)
        assert complaints(browser) == []
        click(browser, "Finish")
        scan.ended()


def test_closing_the_browser_stops_nothing(turn, tmp_path):
    source = Rounds(turn, RATE, 250)
    with Scan(source, tmp_path) as scan:
        with Browser(800, 600) as browser:
            opened(browser, scan)
        gone = scan.watch.tracked  # the browser was killed just now
        done = scan.ended(60)
    assert done.frames == 250
    assert scan.watch.tracked > gone + 20


def test_a_browser_that_does_not_answer_holds_nothing_up(turn, tmp_path):
    source = Rounds(turn, RATE, 250)
    with Scan(source, tmp_path) as scan, Browser(800, 600) as browser:
        opened(browser, scan)
        family = [browser._process.pid, *children(browser._process.pid)]
        for pid in family:
            os.kill(pid, signal.SIGSTOP)
        stood = scan.watch.tracked, scan.feed.dropped
        done = scan.ended(60)
        for pid in family:
            os.kill(pid, signal.SIGCONT)
    assert done.frames == 250
    assert scan.watch.tracked > stood[0] + 20


def test_a_page_that_hangs_holds_nothing_up(turn, tmp_path, monkeypatch):
    hangs = threading.Event()
    monkeypatch.setattr(pages.LivePage, "show", lambda *_: hangs.wait())
    with Scan(Rounds(turn, RATE, 120), tmp_path) as scan:
        done = scan.ended(60)
    hangs.set()
    assert done.frames == 120
    assert scan.watch.tracked > 60


def children(pid: int) -> list[int]:
    """All below a process."""
    said = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
    pairs = [tuple(map(int, line.split())) for line in said.splitlines()]
    below = [child for child, parent in pairs if parent == pid]
    return below + [further for child in below for further in children(child)]


SERVER = """
import sys, time
from dataclasses import replace
import numpy as np
from fusion.live.page import LivePage
from fusion.live.state import LiveState, ShownSurface
rng = np.random.default_rng(1)
page, state = LivePage(int(sys.argv[1])), LiveState(tracking="good", reason="")
def memory():
    return int(open("/proc/self/statm").read().split()[1]) * 4 / 1024
print("ready", flush=True)
sys.stdin.readline()
for count in range(1, 1001):
    if count % 10 == 0:
        n = int(rng.integers(20_000, 30_000))
        points, sigma = rng.normal(0, 0.05, (n, 3)).astype(np.float32), np.full(n, 1e-3, np.float32)
        state = replace(state, surface=ShownSurface(points, sigma))
    pictures = {name: rng.integers(0, 255, (240, 320, 3)).astype(np.uint8) for name in ("color", "depth")}
    state = replace(state, recorded=count, turned=float(count), **pictures)
    page.show(state)
    time.sleep(0.03)
    if count % 100 == 0:
        print(memory(), flush=True)
sys.stdin.readline()
"""


def test_the_server_does_not_grow_in_a_thousand_updates():
    port = free_port()
    command = [sys.executable, "-c", SERVER, str(port)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout.readline() == "ready\n"
        with Browser(800, 600) as browser:
            browser.open(f"http://127.0.0.1:{port}/")
            assert browser.wait_for(f"{TEXT}.includes('tracking')", 60)
            server.stdin.write("\n")
            server.stdin.flush()
            memory = [float(server.stdout.readline()) for _ in range(10)]
            assert browser.wait_for(f"{TEXT}.includes('1000 recorded')", 60)
            assert complaints(browser) == []
    assert memory[-1] < 1.05 * memory[1], memory  # after the first 200, in which buffers find their size
