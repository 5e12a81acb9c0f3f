"""RealSense D400 cameras: stereo, most with a projected texture; and the L515, a scanned beam."""

from fusion.geometry.principle import Principle
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.readout.axial_noise import AxialNoise
from fusion.sensor.effects.readout.depth_quantization import DepthQuantization
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.effects.triangulation.pixel_locking import PixelLocking
from fusion.sensor.sensor import Sensor
from fusion.sensor.working_range import WorkingRange

TUNING = "Intel, Tuning depth cameras for best performance"
LINEARITY = "Intel, Subpixel linearity improvement for RealSense depth cameras"
SHEET = "Intel RealSense D400 series datasheet 337029"
SEARCHED = "f b / 126 (librealsense, realsense-ros #2367) of the preset's camera"
UNIT = "default depth unit of 1 mm"
UNIT_D405 = "default depth unit of 0.1 mm: librealsense #11784"


def realsense_d405() -> Sensor:
    """Near range: baseline 18 mm, no projector, counts of 0.1 mm."""
    source = f"baseline 18 mm: {SHEET} (its origin lies 9 mm beside the middle)"
    works = WorkingRange(0.07, source="realsense-ros #2367: tried, at 640 x 480")
    return _d400("realsense-d405", "RealSense D405", 0.018, source, works, 0.0001, UNIT_D405)


def realsense_d415() -> Sensor:
    """Baseline 55 mm, narrow view."""
    return _d400("realsense-d415", "RealSense D415", 0.055, f"baseline 55 mm: {SHEET}, from memory", _nearest(0.44))


def realsense_d435() -> Sensor:
    """Normal noise of the disparity, 0.08 px, on a well textured target; baseline 50 mm."""
    source = "baseline 50 mm: Intel community, thread 676278"
    return _d400("realsense-d435", "RealSense D435", 0.05, source, _nearest(0.17))


def realsense_d455() -> Sensor:
    """Baseline 95 mm: half the noise of a D435 at the same distance."""
    return _d400("realsense-d455", "RealSense D455", 0.095, f"baseline 95 mm: {SHEET}, from memory", _nearest(0.34))


def realsense_l515() -> Sensor:
    """Scanned beam, modulated light: 2.5 mm at 1 m to 15.5 mm at 9 m; counts of 0.25 mm."""
    return Sensor(
        "realsense-l515",
        Principle.TIME_OF_FLIGHT,
        (
            LateralNoise(sigma_px=0.5),
            AxialNoise(c0=0.0025 - 0.00016, c1=0.0, c2=0.00016),
            DepthQuantization(step=0.00025),
        ),
        sensor="RealSense L515",
        works=WorkingRange(0.25, 9.0, "Intel's product page, from memory"),
        sources={
            "lateral_noise": "guess",
            "axial_noise": "Intel's product page, from memory: 2.5 mm at 1 m, 15.5 mm at 9 m; growth with z^2: guess",
            "depth_quantization": "default depth unit of 0.25 mm, from memory",
        },
    )


def _nearest(depth: float) -> WorkingRange:
    """Where the matcher's search ends; far away it finds something as far as files hold it (librealsense #2723)."""
    return WorkingRange(depth, source=SEARCHED)


def _d400(
    name: str,
    sensor: str,
    baseline: float,
    baseline_source: str,
    works: WorkingRange,
    step: float = 0.001,
    unit: str = UNIT,
) -> Sensor:
    """One matcher for all of them (D4 chip): they differ by baseline [m], optics and unit [m]."""
    own = "" if name == "realsense-d435" else "; as the D435: guess"
    return Sensor(
        name,
        Principle.ACTIVE_STEREO,
        (
            # the depth image is that of the left imager; the right one stands on the side of +x
            ProjectorShadow(baseline=baseline),
            EdgeFattening(window_px=7.0),
            PixelLocking(amplitude=0.03, period=1.0),
            LateralNoise(sigma_px=0.8),
            AxialNoise(sigma_px=0.08, correlation_px=7.0),
            DepthQuantization(step=step),
        ),
        sensor=sensor,
        baseline=baseline,
        works=works,
        std={("pixel_locking", "amplitude"): 0.03},
        sources={
            "projector_shadow": baseline_source,
            "edge_fattening": "matching window: guess",
            "pixel_locking": f"{LINEARITY}, and librealsense #2723, show the wave; its height is a guess",
            "lateral_noise": "guess, as the original Kinect",
            "axial_noise": f"{TUNING}: error grows with z^2; 0.08 px from memory{own}",
            "depth_quantization": unit,
        },
    )
