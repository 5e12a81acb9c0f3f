"""Optics: rays go elsewhere, or images blur, before any light is measured."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.optics.defocus import Defocus
from fusion.sensor.effects.optics.focal_length import FocalLength
from fusion.sensor.effects.optics.lens_distortion import LensDistortion
from fusion.sensor.effects.optics.principal_point import PrincipalPoint
from fusion.sensor.effects.optics.refraction import Refraction

OPTICS: tuple[type[Effect], ...] = (Refraction, FocalLength, PrincipalPoint, LensDistortion, Defocus)
