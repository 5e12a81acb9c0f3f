"""How the trajectory of a moving camera hangs together."""

from dataclasses import dataclass

DRIFT = 0.03  # of the path, where nothing is seen again (guess; 3 % in a simulated furnished room, more before walls)


@dataclass(frozen=True)
class Course:
    """How a trajectory hangs together."""

    path: float  # length of the way, from key frame to key frame [m]
    in_view: bool  # the camera always kept something of all that it saw in view, so that tracking itself held it
    pieces: int  # parts tracked for themselves, after the camera was lost
    joined: int  # of them, those that stand in one frame of reference
    met: int = 0  # pairs of key frames that show a place seen before; `refused` those that the others contradict
    refused: int = 0
    # before, after: how far such pairs were and are apart, rms [m]; NaN where there are none
    before: float = float("nan")
    after: float = float("nan")
    moved: float = 0.0  # largest correction of a camera centre [m]

    @property
    def drift(self) -> float:
        """What is to be expected where nothing was seen again [m]."""
        return DRIFT * self.path

    def values(self) -> dict[str, float | None]:
        """Plain values for JSON [m]."""
        return {
            "path_m": self.path,
            "kept_in_view": self.in_view,
            "pieces": self.pieces,
            "pieces_joined": self.joined,
            "places_seen_again": self.met,
            "refused": self.refused,
            "apart_before_m": self.before if self.met else None,
            "apart_after_m": self.after if self.met else None,
            "largest_correction_m": self.moved,
        }
