"""How far a tracked camera is from the poses that its recording states."""

from dataclasses import asdict, dataclass

from fusion.geometry.trajectory import Trajectory, TrajectoryError, trajectory_error
from fusion.recording.native.scene_file import stated_scene
from fusion.recording.recording import Recording

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
