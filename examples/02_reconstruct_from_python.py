"""A recording becomes a mesh, and every frame says how well it was placed.

    python examples/02_reconstruct_from_python.py RECORDING MESH.ply [SENSOR]

SENSOR is a `sensor.json` or a preset such as kinect-v1: it corrects the depth and weighs every pixel.
"""

import sys
from pathlib import Path

from fusion.mesh.files import write_mesh
from fusion.reconstruction.pipeline import reconstruct
from fusion.reconstruction.settings import ReconstructSettings
from fusion.recording.open import open_recording
from fusion.sensor.file import read_sensor


def main(recording: str, mesh: str, sensor: str = "") -> None:
    """Track and fuse the recording, write the mesh, print the evidence."""
    settings = ReconstructSettings(sensor=read_sensor(sensor) if sensor else None)
    result = reconstruct(open_recording(recording), settings)
    write_mesh(Path(mesh), result.mesh)
    for frame, (residual, share) in enumerate(zip(result.residual, result.inlier_share, strict=True)):
        free = ", ".join(result.unconstrained.get(frame, ()))
        status = result.rejected.get(frame, "ok")
        print(f"{frame:4d} {residual * 1e3:6.2f} mm {share:5.0%}  {status}" + (f"  not fixed: {free}" if free else ""))
    for text in result.judgement.warnings:
        print("note:", text)


if __name__ == "__main__":
    main(*sys.argv[1:4])
