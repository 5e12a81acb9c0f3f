"""The picture of every effect, by its name."""

from effect_pages.before_sensor import BEFORE_SENSOR
from effect_pages.in_sensor import IN_SENSOR
from effect_pages.panel import Picture

PICTURES: dict[str, Picture] = BEFORE_SENSOR | IN_SENSOR
