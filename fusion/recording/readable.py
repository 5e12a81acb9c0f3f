"""One broken file is no reason to lose the other frames; which were lost is told."""

from collections.abc import Iterable, Iterator, Sequence

from fusion.errors import RecordingError
from fusion.recording.recording import Frame, Recording


def readable(recording: Recording, indices: Iterable[int], unread: dict[int, str]) -> Iterator[Frame]:
    """The frames with these indices; of one that cannot be read, index and reason are put into `unread`."""
    for index in indices:
        try:
            frame = recording[index]
        except RecordingError as error:
            unread[index] = str(error)
            continue
        yield frame


def unread_text(unread: dict[int, str]) -> str:
    """How many frames were left out, and why the first; for `unread` of one or more."""
    count = "1 frame" if len(unread) == 1 else f"{len(unread)} frames"
    first = min(unread)
    return f"{count} could not be read and left out, the first is frame {first}: {unread[first]}"


def moving_notes(recordings: Sequence[Recording], used: int) -> list[tuple[str, str]]:
    """What is said where `used` of all frames, readable or not, belong to a view that stands still, and others do not.

    Returns:
        ("ok", sentence), or nothing.
    """
    total = sum(map(len, recordings))
    if used >= total:
        return []
    return [("ok", f"{total - used} of {total} frames belong to no view that stands still: left out")]
