"""Every effect and parameter name that a sensor file may hold, with its unit; only EFFECTS are computed."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters, settings

_NAMES_ONLY = {
    "disparity_distortion": "rms:px map:px coefficients:px decay:1/px",
    "depth_color_misregistration": "rotation:rad translation:m",
    "emitter_parallax": "baseline:m direction:rad",
    "speckle_noise": "sigma_px:px correlation_px:px",
    "fixed_pattern": "rms:m map:m",
    "vertical_banding": "step:px columns:px steps:px",
    "column_delay": "slope:m/px slope_v:m/px",
    "pixel_locking": "amplitude:px period:px",
    "amplitude_dropout": "ir_threshold:count width:count",
    "saturation": "ir_threshold:count",
    "ambient_light": "ambient:lux",
    "temporal_filtering": "memory:1",
    "cyclic_error": "amplitude:m period:m phase:rad",
    "amplitude_error": "coefficient:m exponent:1 ir_reference:count",
    "multipath": "strength:1",
    "stray_light": "fraction:1 width:px",
    "mixed_pixels": "fill:1",
    "pixel_crosstalk": "fraction:1",
    "phase_wrapping": "range:m",
    "motion_artifact": "duration:s",
    "subsurface_scattering": "path:m",
    "specular_reflection": "strength:1 exponent:1",
    "sensor_interference": "fraction:1 beat:Hz",
    "illumination_vignetting": "exponent:1 ir_at_1m:count",
    "projector_shadow": "baseline:m",
    "edge_fattening": "window_px:px",
    "projector_thermal_drift": "coefficient:1/K",
    "temperature_drift": "coefficient:m/K|px/K reference_temperature:degC amplitude:m|px time_constant:s",
    "ambient_flicker": "amplitude:1 frequency:Hz",
    "reference_shape_error": "map:m",
    "tracking_drift": "rate_m:m/frame rate_rad:rad/frame",
    "tsdf_bias": "truncation:m",
    "voxelization": "voxel:m",
    "tabulated": "variables: grid: values:m|px",
}

IMPLEMENTED = {kind.name: kind for kind in EFFECTS}


def _units(kind: type[Effect]) -> dict[str, tuple[str, ...]]:
    units: dict[str, tuple[str, ...]] = dict.fromkeys(settings(kind), ())
    for about in parameters(kind).values():
        units[about.label] = (*units.get(about.label, ()), about.unit)
    return units


# effect name to parameter name to the units it may have (an empty tuple: not checked)
KNOWN: dict[str, dict[str, tuple[str, ...]]] = {
    **{name: _units(kind) for name, kind in IMPLEMENTED.items()},
    **{
        name: {
            parameter: tuple(filter(None, units.split("|")))
            for parameter, units in (entry.split(":", 1) for entry in text.split())
        }
        for name, text in _NAMES_ONLY.items()
    },
}
