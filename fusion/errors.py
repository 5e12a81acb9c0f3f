"""Errors a user can act on: every one says what, where, found, expected and what to do."""


class FusionError(Exception):
    """A problem with the input, told in one line.

    Args:
        what: the problem, as a short statement.
        where: file, frame or option it was met in.
        found: what was there.
        expected: what should have been there.
        do: what the user can do next.
    """

    def __init__(self, what: str, where: object = "", found: object = "", expected: object = "", do: str = "") -> None:
        self.what, self.where, self.do = what, str(where), do
        self.found, self.expected = str(found), str(expected)
        parts = [what]
        parts += [f"in {self.where}"] if self.where else []
        parts += [f"found {self.found}"] if self.found else []
        parts += [f"expected {self.expected}"] if self.expected else []
        parts += [do] if do else []
        super().__init__("; ".join(" ".join(part.split()) for part in parts))


class RecordingError(FusionError):
    """A recording, camera or trajectory file that cannot be used."""


class MeshError(FusionError):
    """A mesh or point cloud that cannot be used."""


class SensorError(FusionError):
    """A sensor model that cannot be used."""


class TrackingError(FusionError):
    """Too few frames could be placed to go on."""


class VolumeError(FusionError):
    """The voxel volume cannot hold what was asked of it."""


class SceneError(FusionError):
    """A scene to simulate that cannot be used."""
