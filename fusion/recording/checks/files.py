"""Are all image files there, whole, and of the camera's size?"""

from collections.abc import Sequence
from pathlib import Path

from fusion.errors import RecordingError
from fusion.files.reading import open_regular
from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

PNG_END = b"IEND\xaeB`\x82"
JPEG_END = b"\xff\xd9"


def check_files(sample: Sample) -> list[Finding]:
    """Missing, cut off and unreadable images. All files are looked at from behind, sampled ones are decoded."""
    recording, findings = sample.recording, []
    if recording.files is not None:
        for kind in ("depth", "color", "color_apart", "ir"):
            findings += _look_at(kind, recording.files.folder, getattr(recording.files, kind))
    for seen in sample.unread[:3]:
        fits = "--camera" not in seen
        do = "copy the file again or take its line out of the list" if fits else "pass --camera for images of this size"
        findings.append(Finding("files", "error", seen, do))
    if not findings:
        findings.append(Finding("files", "ok", f"{len(recording)} frames, all files there and whole"))
    return findings


def _look_at(kind: str, folder: Path, names: Sequence[str | None]) -> list[Finding]:
    missing: list[str] = []
    cut: list[str] = []
    for name in names:
        if name is None:
            continue
        state = _state(folder / name)
        if state:
            (missing if state == "missing" else cut).append(name)
    findings = []
    for state, bad in (("missing", missing), ("cut off or empty", cut)):
        if bad:
            seen = f"{len(bad)} of {len(names)} {kind} images {state}: {', '.join(bad[:3])}{' ...' * (len(bad) > 3)}"
            findings.append(Finding("files", "error", seen, "copy them again or take their lines out of the list"))
    return findings


def _state(path: Path) -> str:
    """ "missing", "cut off" or "" for a file that looks whole."""
    try:
        with open_regular(path, RecordingError) as file:
            start = file.read(8)
            file.seek(0, 2)
            # some writers put a few bytes behind the end
            file.seek(max(0, file.tell() - 256))
            end = file.read()
    except (OSError, RecordingError):
        return "missing"
    if not start:
        return "cut off"
    whole = {b"\x89PNG": PNG_END, b"\xff\xd8\xff": JPEG_END}
    return "cut off" if any(start.startswith(s) and e not in end for s, e in whole.items()) else ""
