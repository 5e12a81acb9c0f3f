"""How a depth camera measures."""

from enum import StrEnum


class Principle(StrEnum):
    """How a depth camera finds a distance; its values are the words of files."""

    STRUCTURED_LIGHT = "structured_light"
    TIME_OF_FLIGHT = "itof"  # indirect: by the phase of modulated light
    ACTIVE_STEREO = "active_stereo"
    UNKNOWN = "unknown"

    @property
    def triangulates(self) -> bool:
        """True where it measures disparities, so that errors are native in pixels."""
        return self in TRIANGULATING

    def or_else(self, other: "Principle") -> "Principle":
        """This one, or another where this is not known."""
        return other if self == Principle.UNKNOWN else self


TRIANGULATING = (Principle.STRUCTURED_LIGHT, Principle.ACTIVE_STEREO)
