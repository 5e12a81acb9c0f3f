"""What the recording's doctor says before a scan, and what readers and the correction add."""

from fusion.recording.checks.drift import check_camera_bumped, check_depth_drifts
from fusion.recording.checks.stillness import check_object_turns
from fusion.recording.looking.doctor import fit_to_scan, quick_look, refuse_if_certain
from fusion.recording.recording import Recording
from fusion.results.light import Light, note
from fusion.scan.settings import ScanSettings
from fusion.volume.voxel_check import voxel_check


def ask_doctor(recording: Recording, settings: ScanSettings) -> tuple[Recording, list[Light]]:
    """What of the recording is scanned, and what looks wrong with it, in a second or two.

    Raises:
        RecordingError: the doctor is certain that the scan will be wrong, and `settings.force` is not set.
    """
    # in a box, or behind masks, only what they hold has to turn
    free = settings.box is None and settings.mask is None
    still = (check_camera_bumped, check_depth_drifts)
    checks = (voxel_check(settings.voxel), *((check_object_turns,) if free else ()), *still)
    findings = quick_look(recording, checks)
    said = refuse_if_certain(findings, recording, settings.force)
    notes = [note("Recording", level, text) for level, text in said]
    return fit_to_scan(recording, findings, settings.force), notes
