"""The picture of every effect, by its name."""

from tools.documentation.effect_pages.before_sensor import BEFORE_SENSOR
from tools.documentation.effect_pages.in_sensor import IN_SENSOR
from tools.documentation.effect_pages.panel import Picture

PICTURES: dict[str, Picture] = BEFORE_SENSOR | IN_SENSOR
