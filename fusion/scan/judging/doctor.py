"""What the recording's doctor says before a scan, and what readers and the correction add."""

from fusion.recording.checks.drift import check_camera_bumped, check_depth_drifts
from fusion.recording.checks.stillness import check_object_turns
from fusion.recording.looking.doctor import quick_look, refuse_if_certain
from fusion.recording.recording import Recording
from fusion.results.light import Light, note
from fusion.scan.settings import ScanSettings
from fusion.volume.voxel_check import voxel_check


def ask_doctor(recording: Recording, settings: ScanSettings) -> list[Light]:
    """What looks wrong with a recording, in a second or two.

    Raises:
        RecordingError: the doctor is certain that the scan will be wrong, and `settings.force` is not set.
    """
    # in a box, or behind masks, only what they hold has to turn
    free = settings.box is None and settings.mask is None
    still = (check_camera_bumped, check_depth_drifts)
    checks = (voxel_check(settings.voxel), *((check_object_turns,) if free else ()), *still)
    said = refuse_if_certain(quick_look(recording, checks), recording, settings.force)
    return [note("Recording", level, text) for level, text in said]
