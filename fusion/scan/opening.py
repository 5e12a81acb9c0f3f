"""The first stage of a scan: what the recording's doctor says, the sensor, and the depth that it corrects."""

from dataclasses import dataclass

from fusion.geometry.camera import Camera
from fusion.progress import stage
from fusion.recording.recording import Recording
from fusion.results.light import Light
from fusion.scan.judging.doctor import ask_doctor
from fusion.scan.settings import ScanSettings
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.correction.summary import CorrectionSummary
from fusion.sensor.presets import default_sensor
from fusion.sensor.sensor import Sensor


@dataclass(frozen=True)
class OpenedScan:
    """What is scanned, and how."""

    recording: Recording  # with corrected depth, and the camera as stated
    settings: ScanSettings  # what was asked for
    sensor: Sensor  # as given, or what the camera's principle suggests
    correction: CorrectionSummary  # what it did to the depth
    doubts: list[Light]  # of the recording's doctor

    @property
    def stated(self) -> Camera:
        """The camera before the scan itself settles its focal length."""
        return self.recording.camera


def open_scan(recording: Recording, settings: ScanSettings) -> OpenedScan:
    """The recording as it is scanned. RecordingError: its doctor is certain that the scan will be wrong."""
    sensor = settings.sensor or default_sensor(recording.camera)
    with stage("looking"):
        recording, doubts = ask_doctor(recording, settings)
    recording, correction = corrected_recording(recording, sensor)
    return OpenedScan(recording, settings, sensor, correction, doubts)
