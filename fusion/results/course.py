"""How the trajectory of a moving camera hangs together."""

from dataclasses import asdict, dataclass

from fusion.geometry.trajectory import Trajectory, TrajectoryError, trajectory_error
from fusion.recording.native.scene_file import stated_scene
from fusion.recording.recording import Recording

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


NOMINAL = "nominal poses, as planned and not measured"


@dataclass(frozen=True)
class OffCourse:
    """A trajectory's error against stated poses."""

    error: TrajectoryError  # after rigid alignment
    against: str  # what these poses are, in words

    def values(self) -> dict[str, float | str]:
        """Plain values for JSON [m]."""
        told = asdict(self.error)
        frames = told.pop("frames")
        return {**{f"{name}_m": value for name, value in told.items()}, "frames": frames, "against": self.against}

    def words(self) -> str:
        """ "15.5 mm rms (mean 13.5, median 12.0, std 7.7, min 1.2, max 43.1) over 120 frames against ..."."""
        e = self.error
        rest = ", ".join(f"{name} {getattr(e, name) * 1e3:.1f}" for name in ("mean", "median", "std", "min", "max"))
        return f"{e.rmse * 1e3:.1f} mm rms ({rest}) over {e.frames} frames against {self.against}"


def off_course(trajectory: Trajectory, recording: Recording) -> OffCourse | None:
    """The error of a trajectory [m] against the recording's own poses; None where it states too few of them."""
    if recording.poses is None:
        return None
    error = trajectory_error(trajectory, recording.poses)
    return None if error is None else OffCourse(error, _against(recording))


def _against(recording: Recording) -> str:
    stated = stated_scene(recording).stated_poses
    source, sigma = stated.source, stated.sigma_m
    if source == "nominal":
        return f"the recording's {NOMINAL}"
    spread = f", +- {sigma * 1e3:g} mm" if sigma else ""
    return f"the recording's {source} poses{spread}" if source else "the recording's own poses"
