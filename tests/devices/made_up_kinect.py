"""Sources that a test makes up: small frames, as many and as fast as it likes, and faults where it wants them."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from threading import Event

import numpy as np

from fusion.devices.source import Description, SourceFrame
from fusion.geometry.camera import Camera

CAMERA = Camera(32, 24, 30.0, 30.0, 15.5, 11.5, depth_scale=5000.0, principle="structured_light", serial="A7")
STEP = 1 / 30


def frame(index: int, missed: int = 0) -> SourceFrame:
    """Another one for each index, so that none can be taken for another."""
    rng = np.random.default_rng(index)
    raw = rng.integers(400, 1000, CAMERA.shape).astype(np.uint16)
    return SourceFrame(
        index,
        1_700_000_000 + STEP * index,
        (raw / 500).astype(np.float32),
        color=rng.integers(0, 255, (*CAMERA.shape, 3)).astype(np.uint8),
        device_time=12.5 + STEP * index,
        host_time=1_700_000_000.25 + STEP * index,
        raw=raw,
        log={"temperature_c": 30.0 + index % 50},
        missed=missed,
    )


@dataclass
class MadeUp:
    """Gives `count` frames, `pause` seconds apart, then raises `error`; `now`: stamped by this machine's clock."""

    count: int = 10
    pause: float = 0.0
    error: Exception | None = None
    missing: dict[int, int] = field(default_factory=dict)
    given: int = 0
    stopped: Event = field(default_factory=Event)
    now: bool = False

    def describe(self) -> Description:
        return Description(
            "made-up", CAMERA, "A7", "1.0", 30.0, color=True, raw="counts", tables={"zero": [120.0, 7.5]}
        )

    def start(self) -> None:
        self.stopped.clear()

    def frames(self) -> Iterator[SourceFrame]:
        for index in range(self.count):
            if self.stopped.is_set():
                return
            time.sleep(self.pause)
            self.given += 1
            one = frame(index, self.missing.get(index, 0))
            yield replace(one, host_time=time.time()) if self.now else one
        if self.error is not None:
            raise self.error

    def stop(self) -> None:
        self.stopped.set()

    def __enter__(self) -> "MadeUp":
        self.start()
        return self

    def __exit__(self, *what: object) -> None:
        self.stop()
