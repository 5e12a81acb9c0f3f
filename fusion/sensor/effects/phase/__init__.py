"""Phase: how a time-of-flight sensor turns light into a distance."""

from fusion.sensor.effect import Effect

PHASE: tuple[type[Effect], ...] = ()
