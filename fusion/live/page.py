"""One page in the browser on which a live scan is seen growing, made by viser; it looks on and holds nothing up.

A thread of its own takes the newest state ten times a second at most and hands viser what has changed. What the page
needs is small or replaced by name, so that the server does not grow. Buttons only set what others look at.
"""

import contextvars
import io
import math
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.errors import DeviceError, FusionError
from fusion.files.extra import extra
from fusion.live.feed import Feed
from fusion.live.state import SECTORS, LiveState, ShownSurface
from fusion.live.watch import Watch
from fusion.progress import note
from fusion.report.kit.html import markup

HERE = "127.0.0.1"  # this machine alone
OFTEN = 0.1  # [s] between two updates
PICTURES = 5  # updates between two pictures: they are the largest part of what is sent
# [m] colours of how sure a point is: green at the first, red from the second on (guess: what a print shows or not)
SURE, UNSURE = 0.0003, 0.002
LONGEST = 3.0  # [s] that the page may take to its end
UNDONE = 30  # frames that a press takes back unless another number stands beside it: a second
MOST_UNDONE = 900  # half a minute
COLORS = {"good": "#3fb950", "weak": "#d29922", "lost": "#f85149"}
RADIUS = 40
WARM = 1800.0  # [s] after which most cameras' depth has settled, see docs/first_scan.md; it may have run before


class LivePage:
    """The server and what stands on its page. Raises DeviceError: viser is not installed, or the port is taken."""

    def __init__(self, port: int) -> None:
        viser = extra("viser", "live", "the page of a live scan", f"port {port}", DeviceError)
        _refuse_taken(port)
        with redirect_stdout(io.StringIO()):  # it greets; what is printed here belongs to the result
            self.server: Any = viser.ViserServer(host=HERE, port=port, verbose=False)
        gui = self.server.gui
        gui.configure_theme(show_logo=False, dark_mode=True)
        gui.set_panel_label("fusion live")
        self._told = gui.add_html(panel(LiveState()))
        self.start, self.pause = gui.add_button("Start"), gui.add_button("Pause")
        self.back = gui.add_number("Frames to undo", UNDONE, min=1, max=MOST_UNDONE, step=1)
        self.undo, self.finish = gui.add_button("Undo"), gui.add_button("Finish")
        self.tilt = gui.add_slider("Tilt [deg]", -30, 30, 1, 0)
        black = np.zeros((24, 32, 3), np.uint8)
        self._color = gui.add_image(black, label="colour", format="jpeg")
        self._depth = gui.add_image(black, label="depth", format="jpeg")
        self.server.scene.set_up_direction("-y")
        self._shown: ShownSurface | None = None
        self._count, self._radius = 0, 0.0

    def show(self, state: LiveState) -> None:
        """Hand viser what has changed."""
        self._told.content = panel(state)
        if state.surface is not None and state.surface is not self._shown:
            self._shown, points = state.surface, state.surface.points
            middle, colors = points.mean(axis=0), colors_of(state.surface.sigma)
            self.server.scene.add_point_cloud("/surface", points - middle, colors, point_size=0.0015)
            radius = float(np.linalg.norm(points - middle, axis=1).max())
            if radius > 1.5 * self._radius:  # not at each growth: a person may have turned it meanwhile
                self._radius = radius
                self._look(radius)
        if self._count % PICTURES == 0:
            if state.color is not None:
                self._color.image = state.color
            if state.depth is not None:
                self._depth.image = state.depth
        self._count += 1

    def stop(self) -> None:
        """Close it."""
        self.server.stop()

    def _look(self, radius: float) -> None:
        """From where the camera stands, near enough to see the object."""
        self.server.initial_camera.position = (0.0, -radius, -3.0 * radius)
        self.server.initial_camera.look_at = (0.0, 0.0, 0.0)
        for client in self.server.get_clients().values():
            client.camera.position = (0.0, -radius, -3.0 * radius)
            client.camera.look_at = (0.0, 0.0, 0.0)


@contextmanager
def page(port: int, feed: Feed, watch: Watch) -> Iterator[None]:
    """The page, while the block runs; no browser need look, and one that goes is not missed.

    What goes wrong on the page is told once and stops nothing; where viser hangs, it is not waited for.
    """
    made, over, around = LivePage(port), threading.Event(), contextvars.copy_context()
    made.start.on_click(lambda _: setattr(feed, "paused", False))
    made.pause.on_click(lambda _: setattr(feed, "paused", True))
    made.undo.on_click(lambda _: watch.undo(int(made.back.value)))
    made.finish.on_click(lambda _: feed.stop())
    motor = _motor(feed.source)
    made.tilt.disabled = motor is None

    def tilt(_event: Any) -> None:
        try:
            if motor is not None:
                motor.tilt(float(made.tilt.value))
        except (FusionError, OSError) as error:  # OSError: of USB
            made.tilt.disabled = True
            around.copy().run(note, f"the camera cannot be tilted: {error}")

    made.tilt.on_update(tilt)
    showing = threading.Thread(target=around.copy().run, args=(_keep_showing, made, watch, over), daemon=True)
    showing.start()
    try:
        yield
    finally:
        over.set()
        ending = threading.Thread(target=made.stop, daemon=True)
        ending.start()
        for thread in (showing, ending):
            thread.join(LONGEST)


def _keep_showing(made: LivePage, watch: Watch, over: threading.Event) -> None:
    """Hand the page each new state until it is over."""
    held, phase = None, ""  # a state is replaced and never changed: whether it is the same one tells all
    try:
        while not over.wait(OFTEN):
            newest, state = watch.state, watch.shown
            if newest is not held or state.phase != phase:
                made.show(state)
            held, phase = newest, state.phase
    except Exception as error:
        note(f"the page is not kept up any more: {error}")


def _motor(source: Any) -> Any:
    """What tilts the camera, or None where it has nothing that does, or it does not answer."""
    try:
        return getattr(source, "motor", None)
    except (FusionError, OSError):
        return None


def colors_of(sigma: NDArray[np.float32]) -> NDArray[np.uint8]:
    """(n, 3) green where a point is sure, red where it is not, between them by the logarithm of sigma (n,) [m]."""
    share = np.clip(np.log(np.maximum(sigma, 1e-9) / SURE) / np.log(UNSURE / SURE), 0, 1)
    red, green = np.minimum(1, 2 * share), np.minimum(1, 2 - 2 * share)
    return (255 * np.stack([red, green, np.full_like(share, 0.25)], axis=1)).astype(np.uint8)


def _refuse_taken(port: int) -> None:
    with socket.socket() as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((HERE, port))
        except OSError as error:
            do = "pass another --port, or --no-view"
            raise DeviceError("the page's port cannot be had", f"port {port}", error.strerror or "", do=do) from error


def panel(state: LiveState) -> str:
    """All that is told beside the pictures."""
    away = "" if math.isnan(state.distance) else f"{state.distance:.2f} m, {state.band}"
    left = "" if state.left is None else f", {_time(state.left)} left"
    rows = {
        "state": state.phase,
        "distance": away or "not known yet",
        "exposure": state.exposure or "not known yet",
        "frames": f"{state.recorded} recorded, {state.lost} lost",
        "view": f"{state.tracked} placed, {state.untracked} not, {state.dropped} too late",
        "rate": f"{state.rate:.0f} a second, {1e3 * state.behind:.0f} ms behind",
        "running": f"{_time(state.warm)}{left}",
        "camera": "warm" if state.warm >= WARM else "may still be warming up (half an hour)",
        "memory": f"{state.memory / 2**20:.0f} MB",
    }
    arcs = [_arc(k, COLORS["good"] if seen else "#555") for k, seen in enumerate(state.seen)]
    angle = math.radians(state.turned)
    ring = _Ring(arcs, RADIUS * math.sin(angle), -RADIUS * math.cos(angle), sum(state.seen) * 360 // SECTORS)
    # a plain string: viser sends no other
    return str(markup("live/panel.html", state=state, color=COLORS[state.tracking], rows=rows, ring=ring))


@dataclass(frozen=True)
class _Ring:
    """The turn as a ring: a path and its colour for each sector, where the table stands now, degrees seen."""

    arcs: list[tuple[str, str]]
    x: float
    y: float
    seen: int


def _arc(sector: int, color: str) -> tuple[str, str]:
    a, b = (2 * math.pi * (sector + k) / SECTORS for k in (0.08, 0.92))
    (x0, y0), (x1, y1) = ((RADIUS * math.sin(t), -RADIUS * math.cos(t)) for t in (a, b))
    return f"M{x0:.1f} {y0:.1f}A{RADIUS} {RADIUS} 0 0 1 {x1:.1f} {y1:.1f}", color


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"
