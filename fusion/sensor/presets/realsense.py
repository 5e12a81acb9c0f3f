"""RealSense D400 cameras: stereo with a projected texture."""

from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.sensor import Sensor

TUNING = "Intel, Tuning depth cameras for best performance"
LINEARITY = "Intel, Subpixel linearity improvement for RealSense depth cameras"


def realsense_d435() -> Sensor:
    """Normal noise of the disparity, 0.08 px, on a well textured target; baseline 50 mm."""
    return Sensor(
        "realsense-d435",
        "active_stereo",
        (
            # the depth image is that of the left imager; the right one stands on the side of +x
            ProjectorShadow(baseline=0.05),
            EdgeFattening(window_px=7.0),
            PixelLocking(amplitude=0.03, period=1.0),
            LateralNoise(sigma_px=0.8),
            AxialNoise(sigma_px=0.08, correlation_px=7.0),
            DepthQuantization(step=0.001),
        ),
        sensor="RealSense D435",
        baseline=0.05,
        std={("pixel_locking", "amplitude"): 0.03},
        sources={
            "projector_shadow": "baseline 50 mm: data sheet, from memory",
            "edge_fattening": "matching window: guess",
            "pixel_locking": f"{LINEARITY}, and librealsense #2723, show the wave; its height is a guess",
            "lateral_noise": "guess, as the original Kinect",
            "axial_noise": f"{TUNING}: error grows with z^2; 0.08 px from memory",
            "depth_quantization": "default depth unit of 1 mm",
        },
    )
