"""Optics: rays go elsewhere, or images blur, before any light is measured."""

from fusion.sensor.effect import Effect

OPTICS: tuple[type[Effect], ...] = ()
