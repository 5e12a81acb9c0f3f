"""Kinect for Xbox 360: structured light of PrimeSense."""

from fusion.geometry.principle import Principle
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.triangulation.vertical_banding import VerticalBanding
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import WorkingRange

NGUYEN = "Nguyen, Izadi, Lovell 2012, near mode"
RANGE = WorkingRange(0.4, 10.0, "nearest of Microsoft's near mode; libfreenect: FREENECT_DEPTH_MM_MAX_VALUE")
SIMKINECT = "github ankurhanda/simkinect: disparity rounded to 1/8 px, baseline 0.075 m"


def kinect_v1() -> Sensor:
    """0.0012 + 0.0019 (z - 0.4)^2 + 0.0001 z^-0.5 theta^2 / (pi/2 - theta)^2 [m]; 1/8 px; shadow; bands."""
    return Sensor(
        "kinect-v1",
        Principle.STRUCTURED_LIGHT,
        (
            ProjectorShadow(baseline=0.075),
            VerticalBanding(step=0.06),
            # the paper's growth of the lateral noise with the angle, 0.035 px at 45 deg, is left out
            LateralNoise(sigma_px=0.8),
            AxialNoise(c0=0.0012 + 0.0019 * 0.4**2, c1=-2 * 0.0019 * 0.4, c2=0.0019, angle=0.0001, angle_exponent=-0.5),
            DepthQuantization(step_px=1 / 8),
        ),
        sensor="Kinect for Xbox 360",
        baseline=0.075,
        works=RANGE,
        std={("vertical_banding", "step"): 0.06},
        sources={
            "projector_shadow": "simkinect: 7.5 cm (Pagliari 2014: about 7.4); on the right: in TUM fr1/rpy 94 % of "
            "the holes beside a near thing, as wide as its shadow, lie to its left",
            "vertical_banding": "forums.structure.io/t/2330 and Chow and Lichti 2013 show bands; their size is a guess",
            "lateral_noise": NGUYEN,
            "axial_noise": NGUYEN,
            "depth_quantization": SIMKINECT,
        },
    )
