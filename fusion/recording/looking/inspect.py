"""The input doctor: what is in a recording, and what looks wrong with it."""

import hashlib
import json
from collections.abc import Callable
from typing import Any

from fusion.errors import RecordingError
from fusion.progress import each
from fusion.recording.checks.color_over_depth import check_color_over_depth
from fusion.recording.checks.depth_values import check_depth_values, range_m, shares
from fusion.recording.checks.files import check_files
from fusion.recording.checks.intrinsics import check_intrinsics
from fusion.recording.checks.poses import check_poses
from fusion.recording.checks.processed import check_processed
from fusion.recording.checks.range_or_z import check_range_or_z
from fusion.recording.checks.resolution import check_neighbours, note_resolution
from fusion.recording.checks.stamps import check_stamps, frames_per_second
from fusion.recording.checks.table_log import check_table_log
from fusion.recording.images.read import read_bytes
from fusion.recording.looking.finding import Finding, Findings
from fusion.recording.looking.sample import Sample, draw
from fusion.recording.native.camera_file import camera_to_dict
from fusion.recording.recording import Recording

Check = Callable[[Sample], list[Finding]]

CHECKS: tuple[Check, ...] = (
    check_files,
    check_stamps,
    check_depth_values,
    check_processed,
    check_intrinsics,
    note_resolution,
    check_neighbours,
    check_range_or_z,
    check_color_over_depth,
    check_poses,
    check_table_log,
)


def inspect(recording: Recording, checks: tuple[Check, ...] = CHECKS) -> Findings:
    """Look at up to 30 frames of a recording and at all its files' names, sizes and ends.

    Args:
        recording: any recording; frames that cannot be loaded become findings.
        checks: what to look at, in this order; rooms further down may add theirs.

    >>> found = fusion.inspect(fusion.open_recording("my_scan"))
    >>> found.severity
    'ok'
    """
    sample = draw(recording)
    findings = [finding for check in each(checks, "checking") for finding in check(sample)]
    told = " ".join(finding.seen for finding in findings)
    # what opening said and no check told again
    notes = [Finding("opening", "warning", text) for text in recording.warnings if text not in told]
    notes = [note for note in notes if not note.seen.startswith("depth.txt is not in the order")]
    return Findings(_summary(sample), tuple(findings + notes), fingerprint(recording))


def fingerprint(recording: Recording) -> str:
    """sha256 (hex) over camera, stamps, file names and sizes, and the first and last depth image."""
    digest = hashlib.sha256(json.dumps(camera_to_dict(recording.camera), sort_keys=True).encode())
    digest.update(recording.timestamps.tobytes())
    files = recording.files
    if files is None:
        for index in {0, len(recording) - 1} if recording.streams is not None and len(recording) else ():
            try:
                digest.update(recording[index].depth.tobytes())
            except RecordingError:
                digest.update(b"missing")
        return digest.hexdigest()
    for name in (*files.depth, *files.color, *files.color_apart, *files.ir):
        path = None if name is None else files.folder / name
        try:
            size = path.stat().st_size if path else 0
        except (OSError, ValueError):
            size = -1
        digest.update(f"{name} {size}\n".encode("utf-8", "surrogatepass"))
    for name in (files.depth[0], files.depth[-1]):
        try:
            digest.update(read_bytes(files.folder / name))
        except RecordingError:  # a missing file has a fingerprint as well
            digest.update(b"missing")
    return digest.hexdigest()


def _summary(sample: Sample) -> dict[str, Any]:
    recording = sample.recording
    stamps = recording.timestamps
    color, ir = recording.has_color, recording.has_ir
    limits = range_m(sample)
    return {
        "path": str(recording.path),
        "format": recording.format,
        "frames": len(recording),
        "color_frames": None if color is None else int(color.sum()),
        "ir_frames": None if ir is None else int(ir.sum()),
        "clock_s": [float(stamps[0]), float(stamps[-1])] if len(stamps) else None,
        "depth_stored": "counts" if recording.in_counts else "metres",
        "duration_s": float(stamps[-1] - stamps[0]) if len(stamps) else 0.0,
        "frames_per_second": frames_per_second(stamps),
        "camera": camera_to_dict(recording.camera),
        "depth_range_m": None if limits is None else list(limits),
        **shares(sample),
        "poses": 0 if recording.poses is None else len(recording.poses),
        "telemetry": list(recording.telemetry),
        "settings": dict(recording.settings),
    }
