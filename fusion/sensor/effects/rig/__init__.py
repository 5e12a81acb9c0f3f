"""The rig: what is seen stands elsewhere, or moves while it is seen."""

from fusion.sensor.effect import Effect

RIG: tuple[type[Effect], ...] = ()
