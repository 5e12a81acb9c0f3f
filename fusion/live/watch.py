"""The thread that lets the model grow and says how it goes, beside the recorder and never in its way."""

import resource
import shutil
import threading
from collections import deque
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fusion.devices.source import SourceFrame
from fusion.geometry.camera import Principle
from fusion.live.feed import FEW, WAITING, Feed
from fusion.live.grow import Grower, Placed
from fusion.live.state import LiveState

OFTEN = 0.1  # [s] between two states: ten a second are all that an eye needs
SURFACE = 1.0  # [s] between two surfaces, and ten times what one takes
LATE = 0.05  # [s] from which on the view makes haste: more than a frame at 30 a second
ACROSS = 320  # [px] of the small pictures
# [m] within which the common cameras of a kind measure an object well (guess, from docs/first_scan.md)
BANDS = {
    Principle.STRUCTURED_LIGHT: (0.5, 1.2),
    Principle.TIME_OF_FLIGHT: (0.4, 1.2),
    Principle.ACTIVE_STEREO: (0.25, 1.0),
}
ANY_BAND = (0.2, 1.5)
BRIGHT, DARK = 250, 10  # of 255: overexposed, underexposed
MUCH = 0.2, 0.6  # share of such pixels that is too much: overexposed, underexposed (guesses)


class Watch:
    """The growing model of a feed; `state` is the newest state, replaced and never changed."""

    def __init__(self, feed: Feed, folder: Path, beside: Executor | None = None) -> None:
        self.feed, self.folder = feed, folder
        about = feed.describe()
        self.camera, self.length = about.camera, about.length
        self.grower = Grower(about.camera)
        self.grower.looking.beside = beside
        self.state = LiveState()
        self.struck: list[tuple[float, float]] = []  # stamps after which and up to which frames are taken out
        self.error: Exception | None = None
        self._undo = 0
        self._told = self._surfaced = self._surface_took = 0.0
        self.tracked = self.untracked = 0
        self._begun = self.feed.clock()
        self._late: deque[float] = deque(maxlen=300)
        self.behind: list[float] = []  # of every frame placed [s]
        self._times: deque[float] = deque(maxlen=60)
        self.waiting: deque[tuple[SourceFrame, float]] = deque()  # for the model to begin
        self._last_angle: float | None = None
        self._thread = threading.Thread(target=self._run, daemon=True, name="fusion-live")

    def start(self) -> None:
        """Begin; what goes wrong in the view is kept in `error` and stops nothing."""
        self._thread.start()

    def join(self, timeout: float) -> None:
        """Wait until the last frame offered is in the view."""
        self._thread.join(timeout)

    @property
    def shown(self) -> LiveState:
        """The newest state; while no frames come, with what a person did since."""
        phase = "finishing" if self.feed.over else "paused" if self.feed.paused else self.state.phase
        return self.state if phase == self.state.phase else replace(self.state, phase=phase)

    def undo(self, frames: int) -> None:
        """Take the last frames out, of the view and of the recording's lists in the end."""
        self._undo = frames

    def _run(self) -> None:
        try:
            while (taken := self.feed.take()) is not None:
                self.see(*taken)
            self.untracked += len(self.waiting)
        except Exception as error:  # the recording goes on
            self.error = error
            self.state = replace(self.state, tracking="lost", reason=f"the view has ended: {error}")

    def see(self, frame: SourceFrame, came: float) -> None:
        """One frame, and when it came [s, by the feed's clock]; one thread at a time."""
        waiting = self.waiting
        self.grower.looking.see(came, frame.depth, self._late_with(came))
        waiting.append((frame, came))
        if self.grower.found:
            # before the model begins, frames that show too little wait: what turns is yet known in part
            while waiting and self._place(*waiting[0]):
                waiting.popleft()
            self.feed.room = WAITING if waiting else FEW
        else:
            self._tell(frame, None)
        if len(waiting) > WAITING:
            waiting.popleft()
            self.untracked += 1

    def _place(self, frame: SourceFrame, came: float) -> bool:
        """False where it shows too little for a model to begin with: it may when more is known."""
        if self._undo:
            frames, self._undo = self._undo, 0
            after = self.grower.undo(frames)
            if after is not None:
                self.struck.append((after, frame.timestamp))
        placed = self.grower.take(frame, self._late_with(came))
        if not placed.tracked.tried and not self.grower.count:
            self._tell(frame, placed)
            return False
        now = self.feed.clock()
        self.tracked += placed.tracked.ok
        self.untracked += not placed.tracked.ok
        if placed.tracked.ok:
            self._times.append(now)
            self._late.append(now - came)
            self.behind.append(now - came)
            self._last_angle = float(np.rad2deg(self.grower.turned.angle))
        self._tell(frame, placed)
        return True

    def _late_with(self, came: float) -> bool:
        return self.feed.clock() - came > LATE

    def _tell(self, frame: SourceFrame, placed: Placed | None) -> None:
        now = self.feed.clock()
        if now - self._told < OFTEN:
            return
        self._told = now
        turned, before = self.grower.turned, self.state
        surface = before.surface
        if placed is not None and now - self._surfaced > max(SURFACE, 10 * self._surface_took):
            surface = self.grower.surface()
            self._surfaced, self._surface_took = self.feed.clock(), self.feed.clock() - now
        distance = np.nan if placed is None else placed.distance
        tracking, reason = _words(placed)
        color = frame.color if frame.color is not None else frame.color_apart
        span = self._times[-1] - self._times[0] if len(self._times) > 1 else 0.0
        self.state = LiveState(
            phase="looking" if placed is None else "scanning",
            recorded=self.feed.recorded,
            lost=self.feed.lost,
            tracked=self.tracked,
            untracked=self.untracked,
            dropped=self.feed.dropped,
            rate=(len(self._times) - 1) / span if span > 0 else 0.0,
            behind=float(np.median(self._late)) if self._late else 0.0,
            tracking=tracking,
            reason=reason,
            back_to=self._last_angle if tracking == "lost" else None,
            turned=float(np.rad2deg(turned.angle)),
            seen=tuple(turned.seen.tolist()),
            distance=distance,
            band=_band(distance, self.camera.principle),
            exposure=_exposure(color),
            warm=now - self._begun,
            memory=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            left=self._left(now),
            surface=surface,
            color=None if color is None else _small(color),
            depth=_depth_picture(frame.depth),
        )

    def _left(self, now: float) -> float | None:
        """Until a source that ends is over, or else until the disk is full at this rate."""
        rate = self.feed.recorded / max(now - self._begun, 1e-3)
        if self.length is not None:
            return (self.length - self.feed.recorded) / rate if rate else None
        pixels = self.camera.width * self.camera.height
        try:  # two bytes of depth and as much of raw, packed by about a half, and three of colour
            return shutil.disk_usage(self.folder).free / max(rate * pixels * 5, 1.0)
        except OSError:
            return None


def _band(distance: float, principle: Principle) -> str:
    low, high = BANDS.get(principle, ANY_BAND)
    if not np.isfinite(distance):
        return ""
    return "too near" if distance < low else "too far" if distance > high else "good"


def _words(placed: Placed | None) -> tuple[str, str]:
    if placed is None:
        return "lost", "nothing turns yet: let the table turn"
    if not placed.tracked.ok:
        return "lost", placed.tracked.status
    if placed.weak:
        open_to = ", ".join(placed.tracked.unconstrained)
        return "weak", f"the surface does not tell {open_to}" if open_to else "fewer points fit than usual"
    return "good", ""


def _exposure(color: NDArray[np.uint8] | None) -> str:
    if color is None:
        return "no colour image"
    some = color[::8, ::8].max(axis=-1)
    if (some >= BRIGHT).mean() > MUCH[0]:
        return "too bright"
    return "too dark" if (some <= DARK).mean() > MUCH[1] else "good"


def _small(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    step = max(1, image.shape[1] // ACROSS)
    return np.ascontiguousarray(image[::step, ::step])


def _depth_picture(depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    """(h, w, 3) near is bright; missing is black."""
    step = max(1, depth.shape[1] // ACROSS)
    some = depth[::step, ::step]
    known, fewer = np.isfinite(some), some[::2, ::2]
    fewer = fewer[np.isfinite(fewer)]
    low, high = np.percentile(fewer, (2, 98)) if len(fewer) else (0.0, 1.0)
    share = np.clip((high - np.where(known, some, high)) / max(float(high - low), 1e-6), 0, 1)
    picture = cv2.applyColorMap((255 * share).astype(np.uint8), cv2.COLORMAP_VIRIDIS)[..., ::-1]
    return np.asarray(np.where(known[..., None], picture, 0), np.uint8)
