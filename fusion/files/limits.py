"""How much one input may ask for. A recording is somebody else's file: its header is a claim, not an order."""

from fusion.errors import FusionError

USUAL_GB = 2.0  # of one file, image or array when it is unpacked; far above any that a depth camera writes
OPTION = "--allow-gb"

_allowed = USUAL_GB


def allow(gigabytes: float) -> None:
    """From now on, in this process: one input may take this much [GB]. The console program does so when it is asked."""
    global _allowed
    _allowed = gigabytes


def check_size(size: float, path: object, error: type[FusionError] = FusionError, what: str = "a file") -> None:
    """Refuse what would take more memory than is allowed, before any is taken.

    Args:
        size: what it takes when it is read [bytes].
    """
    if size > _allowed * 1e9:
        found, expected = f"{size / 1e9:.3g} GB", f"at most {_allowed:g} GB"
        raise error(f"{what} is too large", path, found, expected, f"if you trust it, raise the limit with {OPTION}")
