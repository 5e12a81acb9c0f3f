"""fusion: metric 3D scanning with depth cameras.

    >>> import fusion
    >>> recording = fusion.open_recording("my_scan")
    >>> recording
    <Recording my_scan: native, 26 frames of 160 x 120 in 12.5 s; depth, color, ir, poses, scene, turntable_deg>
    >>> recording[0].depth.shape
    (120, 160)

Lengths are metres, times seconds, angles radians. The names of `__all__` are the public ones; each is loaded when it is
first used, so that the import costs nothing. `fusion/__init__.pyi` tells type checkers and editors where they are.
"""

import importlib

__version__ = "0.1.0"

# module: its public names. None may be called like a module or folder beside this file, which would take its place
_PUBLIC = {
    "errors": "FusionError",
    "geometry.camera": "Camera",
    "geometry.trajectory": "Trajectory",
    "recording.native.camera_file": "write_camera",
    "recording.cameras.presets": "find_camera",
    "recording.writing.convert": "convert_recording",
    "recording.looking.inspect": "inspect",
    "recording.open": "open_recording",
    "recording.recording": "Frame Recording",
    "recording.writing.write": "write_recording",
    "devices.open": "open_source",
    "devices.record": "Recorded RecordSettings record_source",
    "devices.source": "Description Source SourceFrame",
    "mesh.comparison.compare": "CompareSettings Comparison compare",
    "mesh.files": "read_mesh write_mesh",
    "mesh.mesh": "Mesh",
    "printing.ready": "PrintSettings Printable print_ready",
    "repeatability.repeat": "Repeat RepeatSettings repeat",
    "sensor.effect": "Effect",
    "sensor.files.sensor_file": "read_sensor write_sensor",
    "sensor.parameter": "parameter",
    "sensor.sensor": "Sensor",
    "sensor.view": "View",
    "calibration.depth.calibration": "DepthSettings calibrate_depth",
    "calibration.lens.boards.board": "read_board",
    "calibration.lens.intrinsics": "LensSettings calibrate_intrinsics",
    "calibration.noise.calibration": "NoiseSettings calibrate_noise",
    "evaluation.evaluate": "EvaluationSettings evaluate",
    "volume.dense": "DenseField",
    "volume.settings": "VolumeSettings",
    "volume.volume": "Volume",
    "simulation.exporting.compare": "SensorComparison compare_sensors",
    "simulation.exporting.export": "Export export_sensor",
    "simulation.ideal.frame": "IdealFrame",
    "simulation.ideal.sense": "sense sense_all",
    "simulation.scene.scene_file": "read_scene",
    "simulation.scenes": "built_in",
    "simulation.simulate": "Simulation simulate",
    "simulation.write": "write_simulation",
    "files.json_values": "json_values",
    "discrepancy.explain": "Explanation explain",
    "discrepancy.verdict.content": "Verdict",
    "discrepancy.verdict.verdict": "verdict_of",
    "reconstruction.pipeline": "reconstruct",
    "reconstruction.result": "Reconstruction",
    "reconstruction.settings": "ReconstructSettings",
    "scan.pipeline": "scan_turntable",
    "scan.result": "Scan",
    "scan.settings": "ScanSettings",
    "passes.one_pass": "Pass",
    "passes.opened": "open_pass",
    "passes.pipeline": "merge_passes",
    "passes.result": "Merged",
    "passes.settings": "MergeSettings",
}
_HOME = {name: f"fusion.{module}" for module, names in _PUBLIC.items() for name in names.split()}
__all__ = ["__version__", *sorted(_HOME)]


def __getattr__(name: str) -> object:
    """A public name, loaded now that it is used (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module 'fusion' has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(_HOME[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
