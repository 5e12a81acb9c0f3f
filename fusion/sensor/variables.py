"""Variables that an error may depend on, by the names that files and verdicts use."""

from collections.abc import Callable
from typing import Any

from fusion.sensor.laws.disparity import disparity
from fusion.sensor.view import Image, View

# each variable as an array that broadcasts to (h, w), or None where it is not known
VARIABLES: dict[str, Callable[[Image, View], Any]] = {
    "depth": lambda depth, view: depth,
    "range": lambda depth, view: depth * view.stretch,
    "disparity": disparity,
    "u": lambda depth, view: view.u,
    "v": lambda depth, view: view.v,
    "radius": lambda depth, view: view.radius,
    "incidence": lambda depth, view: view.incidence,
    "amplitude": lambda depth, view: view.ir,
    "reflectance": lambda depth, view: view.reflectance,
    "edge": lambda depth, view: None if view.edges is None else view.edges.distance,
    "time": lambda depth, view: view.moment.time,
    "temperature": lambda depth, view: view.moment.temperature,
    "table_angle": lambda depth, view: view.moment.table_angle,
    "ambient": lambda depth, view: view.moment.ambient,
}
