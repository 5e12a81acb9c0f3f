"""The public names for type checkers and editors; `__init__.py` loads the same when they are used."""

from fusion.calibration.depth.calibration import DepthSettings as DepthSettings
from fusion.calibration.depth.calibration import calibrate_depth as calibrate_depth
from fusion.calibration.lens.board import read_board as read_board
from fusion.calibration.lens.intrinsics import LensSettings as LensSettings
from fusion.calibration.lens.intrinsics import calibrate_intrinsics as calibrate_intrinsics
from fusion.calibration.noise.calibration import NoiseSettings as NoiseSettings
from fusion.calibration.noise.calibration import calibrate_noise as calibrate_noise
from fusion.discrepancy.explain import Explanation as Explanation
from fusion.discrepancy.explain import explain as explain
from fusion.discrepancy.verdict.verdict import verdict_of as verdict_of
from fusion.errors import FusionError as FusionError
from fusion.evaluation.evaluate import EvaluationSettings as EvaluationSettings
from fusion.evaluation.evaluate import evaluate as evaluate
from fusion.geometry.camera import Camera as Camera
from fusion.geometry.trajectory import Trajectory as Trajectory
from fusion.mesh.compare import CompareSettings as CompareSettings
from fusion.mesh.compare import Comparison as Comparison
from fusion.mesh.compare import compare as compare
from fusion.mesh.files import read_mesh as read_mesh
from fusion.mesh.files import write_mesh as write_mesh
from fusion.mesh.mesh import Mesh as Mesh
from fusion.recording.camera_file import write_camera as write_camera
from fusion.recording.camera_presets import find_camera as find_camera
from fusion.recording.convert import convert_recording as convert_recording
from fusion.recording.inspect import inspect as inspect
from fusion.recording.open import open_recording as open_recording
from fusion.recording.recording import Frame as Frame
from fusion.recording.recording import Recording as Recording
from fusion.recording.write import write_recording as write_recording
from fusion.scan.pipeline import scan_turntable as scan_turntable
from fusion.scan.result import Scan as Scan
from fusion.scan.settings import ScanSettings as ScanSettings
from fusion.sensor.file import read_sensor as read_sensor
from fusion.sensor.file import write_sensor as write_sensor
from fusion.sensor.sensor import Sensor as Sensor
from fusion.simulation.scene_file import read_scene as read_scene
from fusion.simulation.scenes import built_in as built_in
from fusion.simulation.simulate import Simulation as Simulation
from fusion.simulation.simulate import simulate as simulate
from fusion.simulation.write import write_simulation as write_simulation
from fusion.volume.dense import DenseField as DenseField
from fusion.volume.settings import VolumeSettings as VolumeSettings
from fusion.volume.volume import Volume as Volume

__version__: str
