"""A recording becomes a mesh, and every frame says how well it was placed.

    python examples/02_reconstruct_from_python.py RECORDING MESH.ply [SENSOR]

SENSOR is a `sensor.json` or a preset such as kinect-v1: it corrects the depth and weighs every pixel.
"""

import sys

import fusion


def main(recording: str, mesh: str, sensor: str = "") -> None:
    """Track and fuse the recording, write the mesh, print the evidence."""
    settings = fusion.ReconstructSettings(sensor=fusion.read_sensor(sensor) if sensor else None)
    result = fusion.reconstruct(fusion.open_recording(recording), settings)
    fusion.write_mesh(mesh, result.mesh)
    for frame, (residual, share) in enumerate(zip(result.residual, result.inlier_share, strict=True)):
        free = ", ".join(result.unconstrained.get(frame, ()))
        status = result.rejected.get(frame, "ok")
        print(f"{frame:4d} {residual * 1e3:6.2f} mm {share:5.0%}  {status}" + (f"  not fixed: {free}" if free else ""))
    for text in result.judgement.warnings:
        print("note:", text)
    print(result)


if __name__ == "__main__":
    main(*sys.argv[1:4])
