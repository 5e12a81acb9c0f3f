"""Light: what is lit, what comes back, and what comes by another way."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.light.ambient_flicker import AmbientFlicker
from fusion.sensor.effects.light.ambient_light import AmbientLight
from fusion.sensor.effects.light.illumination_vignetting import IlluminationVignetting
from fusion.sensor.effects.light.multipath import Multipath
from fusion.sensor.effects.light.projector_shadow import ProjectorShadow
from fusion.sensor.effects.light.specular_reflection import SpecularReflection
from fusion.sensor.effects.light.stray_light import StrayLight
from fusion.sensor.effects.light.subsurface_scattering import SubsurfaceScattering

# from the lamp to the surface, at the surface, and back
LIGHT: tuple[type[Effect], ...] = (
    IlluminationVignetting,
    ProjectorShadow,
    AmbientLight,
    AmbientFlicker,
    SubsurfaceScattering,
    SpecularReflection,
    Multipath,
    StrayLight,
)
