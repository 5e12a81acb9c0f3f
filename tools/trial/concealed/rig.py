"""Cases of a turntable: what is wrong with the table or the clock, and how it looks."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tools.trial.concealed.decks import camera_of
from tools.trial.concealed.laws.law import Law
from tools.trial.concealed.rays import Camera
from tools.trial.concealed.shot import Shot
from tools.trial.concealed.turning import Run, Turn, runs_of, table_shots

Rng = np.random.Generator

SMALL = {"turntable_eccentricity": 1e-4, "turntable_encoder_error": 1e-4, "timestamp_offset": 1e-3}
SMALL["rolling_shutter"] = 1e-6
# how often each, and nothing at all
DRAWN = ("turntable_eccentricity", "turntable_encoder_error", "timestamp_offset", "rolling_shutter", "")


@dataclass(frozen=True)
class Table:
    """Attributes:
    camera, runs: what was recorded.
    really: shots as they were, per recording.
    stated: shots as the log has them: all errors absent but those of the pose.
    """

    camera: Camera
    runs: list[Run]
    really: list[list[Shot]]
    stated: list[list[Shot]]

    def looks_like(self, name: str) -> list[list[Shot]]:
        """All shots in one row, with a small error of a kind, in each of its directions."""
        tables = [table_shots(self.camera, self.runs, turn) for turn in _directions(name)]
        return [[shot for run in table for shot in run] for table in tables]


def table_of(rng: Rng) -> tuple[Table, Law | None]:
    """A table with one thing wrong, or nothing."""
    camera, runs = camera_of(rng, False), runs_of(rng)
    name = str(rng.choice(DRAWN))
    turn, law = Turn(), None
    if name:
        size, turn = DRAWS[name](rng)
        about = (PARAMETER[name], size) if name in PARAMETER else None
        variables = ("table_angle",) if name.startswith("turntable") else ("velocity",)
        law = Law(name, "rig", lambda place: None, variables, accept=(name,), parameter=about)
    return Table(camera, runs, table_shots(camera, runs, turn), table_shots(camera, runs, Turn())), law


PARAMETER = {"turntable_eccentricity": "offset", "timestamp_offset": "offset", "rolling_shutter": "line_time"}


def _eccentric(rng: Rng) -> tuple[float, Turn]:
    offset = float(rng.uniform(0.2e-3, 1.5e-3))
    return offset, Turn(offset=offset, phase=float(rng.uniform(0, 2 * np.pi)))


def _encoder(rng: Rng) -> tuple[float, Turn]:
    size = float(np.deg2rad(rng.uniform(0.05, 0.4)))
    more = () if rng.random() < 0.5 else ((size * float(rng.uniform(0.3, 0.8)), float(rng.uniform(0, 2 * np.pi))),)
    return size, Turn(harmonics=((size, float(rng.uniform(0, 2 * np.pi))), *more))


def _late(rng: Rng) -> tuple[float, Turn]:
    late = float(rng.choice([-1, 1]) * rng.uniform(3e-3, 30e-3))
    return late, Turn(late=late)


def _rolling(rng: Rng) -> tuple[float, Turn]:
    line = float(rng.choice([-1, 1]) * rng.uniform(5e-5, 2e-4))
    return line, Turn(line=line)


DRAWS: dict[str, Callable[[Rng], tuple[float, Turn]]] = {
    "turntable_eccentricity": _eccentric,
    "turntable_encoder_error": _encoder,
    "timestamp_offset": _late,
    "rolling_shutter": _rolling,
}


def _directions(name: str) -> list[Turn]:
    size, quarter = SMALL[name], np.pi / 2
    if name == "turntable_eccentricity":
        return [Turn(offset=size, phase=phase) for phase in (0.0, quarter)]
    if name == "turntable_encoder_error":
        once = [Turn(harmonics=((size, phase),)) for phase in (0.0, quarter)]
        return [*once, *(Turn(harmonics=((0.0, 0.0), (size, phase))) for phase in (0.0, quarter))]
    return [Turn(late=size) if name == "timestamp_offset" else Turn(line=size)]
