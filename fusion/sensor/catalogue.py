"""Every effect and parameter name that a sensor file may hold, with its unit; only EFFECTS are computed."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.parameter import parameters, settings

_NAMES_ONLY = {
    "depth_color_misregistration": "rotation:rad translation:m",
    "reference_shape_error": "map:m",
    "tracking_drift": "rate_m:m/frame rate_rad:rad/frame",
    "tsdf_bias": "truncation:m",
    "voxelization": "voxel:m",
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
