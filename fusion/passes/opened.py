"""A pass from what a user has: a result of `fusion turntable`, or a recording, which is scanned first."""

from dataclasses import replace
from pathlib import Path

from fusion.errors import TrackingError
from fusion.passes.from_result import ResultReading, is_result, pass_of_result
from fusion.passes.one_pass import Pass, pass_of_scan
from fusion.recording.open import open_recording
from fusion.recording.recording import Recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings
from fusion.sensor.sensor import Sensor


def open_pass(
    what: Recording | Path | str,
    sensor: Sensor | None = None,
    camera: Path | str | None = None,
    topic: str | None = None,
) -> Pass:
    """One pass for `merge_passes`, with a sensor model and a camera of its own.

    Args:
        what: a result folder of `fusion turntable`, or a recording, which is scanned first.
        sensor: corrects and rates the depth; None takes what the scan used, or what the camera suggests.
        camera, topic: of the recording, as `open_recording` takes them.

    Raises:
        FusionError: a result that is not whole.
        RecordingError: there is no such recording.
        TrackingError: it cannot be scanned, or the scan failed.

    >>> one = fusion.open_pass("my_scan", sensor=fusion.read_sensor("kinect-v2-indoors"))
    >>> len(one.frames) > 0
    True
    """
    if not isinstance(what, Recording):
        if is_result(Path(what)):
            return replace(pass_of_result(Path(what), ResultReading(sensor, camera, topic)), name=Path(what).name)
        what = open_recording(what, camera, topic)
    settings = ScanSettings(sensor=sensor)
    scan = scan_turntable(what, settings)
    worth = scan.judgement.worth
    if worth.word == "failed":
        reason = worth.reasons[0].reason.rstrip(".")
        raise TrackingError("the scan of a pass failed", what.path, reason, do=worth.reasons[0].do)
    return pass_of_scan(what, scan, settings)
