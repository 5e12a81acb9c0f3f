"""Which effects each kind of sensor may conceal. The order is part of what a seed makes."""

import numpy as np

from tools.trial.furnished.physics.bench import Bench, CameraRun
from tools.trial.furnished.planted import of_both, of_disparity, of_light, unknown
from tools.trial.furnished.planted.plant import Planted, Planter, Soil

FLIGHT: dict[str, Planter] = {
    "depth_offset": of_light.depth_offset,
    "depth_scale": of_both.depth_scale,
    "cyclic_error": of_light.cyclic_error,
    "amplitude_error": of_light.amplitude_error,
    "temperature_drift": of_both.temperature_drift,
    "multipath": of_light.multipath,
    "stray_light": of_light.stray_light,
    "mixed_pixels": of_light.mixed_pixels,
    "pixel_crosstalk": of_light.pixel_crosstalk,
    "motion_artifact": of_light.motion_artifact,
    "rolling_shutter": of_both.rolling_shutter,
    "timestamp_offset": of_both.timestamp_offset,
    "focal_length": of_both.focal_length,
    "principal_point": of_both.principal_point,
    "lens_distortion": of_both.lens_distortion,
    "column_delay": of_light.column_delay,
    "fixed_pattern": of_both.fixed_pattern,
    "ambient_light": of_light.ambient_light,
    "axial_noise": of_both.axial_noise,
    "amplitude_dropout": of_light.amplitude_dropout,
    "saturation": of_light.saturation,
    "depth_quantization": of_both.depth_quantization,
    "subsurface_scattering": of_light.subsurface_scattering,
    "phase_wrapping": of_light.phase_wrapping,
    "emitter_parallax": of_light.emitter_parallax,
    "refraction": of_both.refraction,
    "tracking_drift": of_both.tracking_drift,
    "defocus": of_light.defocus,
    "temporal_filtering": of_light.temporal_filtering,
    "unknown:ghost": unknown.ghost,
    "unknown:incpen": unknown.penetration,
    "unknown:ripple": unknown.ripple,
    "unknown:step": unknown.jump,
    "unknown:quad": unknown.square,
    "unknown:gain": unknown.gain,
    "unknown:sectors": unknown.sectors,
}
MATCHING: dict[str, Planter] = {
    "disparity_offset": of_disparity.disparity_offset,
    "disparity_distortion": of_disparity.disparity_distortion,
    "pixel_locking": of_disparity.pixel_locking,
    "vertical_banding": of_disparity.vertical_banding,
    "speckle_noise": of_disparity.speckle_noise,
    "projector_thermal_drift": of_disparity.projector_thermal_drift,
    "depth_scale": of_both.depth_scale,
    "disparity_tilt": of_disparity.disparity_tilt,
    "edge_fattening": of_disparity.edge_fattening,
    "depth_quantization": of_both.depth_quantization,
    "axial_noise": of_both.axial_noise,
    "temperature_drift": of_both.temperature_drift,
    "focal_length": of_both.focal_length,
    "principal_point": of_both.principal_point,
    "lens_distortion": of_both.lens_distortion,
    "timestamp_offset": of_both.timestamp_offset,
    "rolling_shutter": of_both.rolling_shutter,
    "tracking_drift": of_both.tracking_drift,
    "refraction": of_both.refraction,
    "unknown:slope": of_disparity.slope,
    "unknown:step": unknown.jump,
    "lateral_noise": of_disparity.lateral_noise,
}


def plant(name: str, rng: np.random.Generator, bench: Bench, recordings: list[CameraRun], boost: float) -> Planted:
    planters = FLIGHT if bench.sensor.flight else MATCHING
    sign = rng.choice([-1, 1])
    return planters[name](Soil(rng, bench, recordings, boost, sign))


def word(name: str) -> str:
    """The name that a right answer says."""
    if name.startswith("unknown"):
        return "unknown"
    return "disparity_distortion" if name == "disparity_tilt" else name
