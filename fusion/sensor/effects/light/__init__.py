"""Light: what is lit, what comes back, and what comes by another way."""

from fusion.sensor.effect import Effect

LIGHT: tuple[type[Effect], ...] = ()
