"""The doctor's quick look before a scan: what would make it fail or be wrong, told in about a second."""

from dataclasses import replace

import numpy as np

from fusion.errors import RecordingError
from fusion.recording.ahead import ahead
from fusion.recording.checks.color_over_depth import check_color_over_depth, is_elsewhere
from fusion.recording.checks.depth_values import check_depth_values
from fusion.recording.checks.intrinsics import check_intrinsics
from fusion.recording.checks.range_or_z import check_range_or_z
from fusion.recording.checks.resolution import check_neighbours, check_resolution
from fusion.recording.checks.table_log import check_table_log
from fusion.recording.looking.finding import SEVERITIES, Finding
from fusion.recording.looking.inspect import Check
from fusion.recording.looking.sample import draw
from fusion.recording.recording import Recording

FRAMES = 12  # a frame of 640 x 480 takes 25 ms; a turn shows itself every 30 degrees
QUICK: tuple[Check, ...] = (
    check_resolution,
    check_neighbours,
    check_depth_values,
    check_intrinsics,
    check_range_or_z,
    check_color_over_depth,
    check_table_log,
)


def quick_look(recording: Recording, more: tuple[Check, ...] = (), max_depth: float | None = None) -> list[Finding]:
    """What looks wrong with a recording, errors first; nothing where all is well.

    Args:
        recording: as it was opened, its depth not corrected.
        more: checks beside the usual ones, such as `check_camera_moves` or `check_object_turns`.
        max_depth: the further checks do not see what is farther [m].
    """
    sample = draw(recording, FRAMES, FRAMES)
    if not np.isfinite(sample.medians).any():  # whoever needs depth says so
        return []
    near = sample
    if max_depth is not None:
        cut = {i: np.where(depth <= max_depth, depth, np.float32(np.nan)) for i, depth in sample.depths.items()}
        near = replace(sample, depths=cut)
    asked = [*((check, sample) for check in QUICK), *((check, near) for check in more)]
    findings = [f for said in ahead(lambda ask: ask[0](ask[1]), asked) for f in said()]
    if any(finding.severity == "error" for finding in findings):  # it may be why
        findings += [Finding("files", "warning", seen) for seen in sample.unread[:1]]
    wrong = [finding for finding in findings if finding.severity != "ok"]
    return sorted(wrong, key=lambda finding: -SEVERITIES.index(finding.severity))


def fit_to_scan(recording: Recording, findings: list[Finding], force: bool = False) -> Recording:
    """The recording without colour that lies elsewhere than depth; `force`: as it is."""
    return recording.without_color() if is_elsewhere(findings) and not force else recording


def refuse_if_certain(findings: list[Finding], recording: Recording, force: bool = False) -> list[tuple[str, str]]:
    """The findings as ("warning" or "bad", sentence), worst first.

    Args:
        force: go on where an error was found.

    Raises:
        RecordingError: the first error, when there is one and `force` is not set.
    """
    unread = "".join(f"; {finding.seen}" for finding in findings if finding.check == "files")
    for finding in findings:
        if finding.severity == "error" and not force:
            do = f"{finding.do} (--force goes on all the same){unread}"
            raise RecordingError(finding.seen, recording.path, do=do)
    levels = {"error": "bad", "warning": "warning"}
    return [(levels[f.severity], f"{f.seen}; {f.do}" if f.do else f.seen) for f in findings]
