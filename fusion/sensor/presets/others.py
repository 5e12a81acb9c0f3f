"""Cameras of single makers: Luxonis OAK-D, and the LiDAR of iPhones and iPads."""

from fusion.geometry.principle import Principle
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import WorkingRange

LUXONIS = "docs.luxonis.com, stereo depth"
POLYCAM = "github PolyCam/polyform: details below 1 to 2 cm are not resolvable"


def oak_d() -> Sensor:
    """Stereo of two cameras 75 mm apart, disparities in eighths of a pixel."""
    return Sensor(
        "oak-d",
        Principle.ACTIVE_STEREO,
        (
            ProjectorShadow(baseline=0.075),
            EdgeFattening(window_px=7.0),
            LateralNoise(sigma_px=0.8),
            AxialNoise(sigma_px=0.2, correlation_px=7.0),
            DepthQuantization(step_px=1 / 8),
        ),
        sensor="OAK-D",
        baseline=0.075,
        works=WorkingRange(
            0.35, source=f"{LUXONIS}: 95 px of disparity are 0.70 m, twice as many (extended) half of it"
        ),
        sources={
            "projector_shadow": f"baseline 75 mm: {LUXONIS}",
            "edge_fattening": "matching window: guess",
            "lateral_noise": "guess, as the original Kinect",
            "axial_noise": f"guess below the limit of {LUXONIS}: all errors within 2 % at 4 m, 0.3 px",
            "depth_quantization": f"subpixel mode, three bits: {LUXONIS}",
        },
    )


def iphone_lidar() -> Sensor:
    """24 x 24 beams that a network fills up to 256 x 192 with the colour picture: neighbours share their errors."""
    return Sensor(
        "iphone-lidar",
        Principle.UNKNOWN,
        (LateralNoise(sigma_px=2.0), AxialNoise(c0=0.005, c1=0.0, c2=0.001, correlation_px=10.0)),
        sensor="iPhone LiDAR",
        works=WorkingRange(0.0, 5.0, "Apple, of the iPad Pro of 2020, from memory: up to 5 m"),
        sources={"lateral_noise": f"guess; {POLYCAM}", "axial_noise": f"guess; {POLYCAM}"},
    )
