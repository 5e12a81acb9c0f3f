"""Is a measured model fit for others? It says of which camera it is, how well each number is known, and whence."""

from fusion.geometry.camera import Principle
from fusion.sensor.sensor import Sensor
from fusion.sensor.words.description import description

GUESS = "guess"  # how sources begin that are none


def shortcomings(sensor: Sensor) -> list[str]:
    """What is missing in a model that others are to rely on, one sentence each; nothing where it is complete.

    Its file was read before: names, units and bounds are right then.
    """
    content = description(sensor)
    found = []
    if not sensor.sensor:
        found.append("sensor: it does not say which camera it is of")
    if sensor.principle == Principle.UNKNOWN:
        found.append("principle: it does not say how the camera measures")
    if not sensor.effects:
        found.append("effects: it has none, which is an ideal sensor")
    for effect in content.effects:
        name, source = effect.effect, effect.source.strip()
        if not source:
            found.append(f"{name}: its numbers have no source")
        elif source.lower().startswith(GUESS):
            found.append(f"{name}: its source is a guess")
        for parameter, row in effect.parameters.items():
            if row.unit and row.std is None:
                found.append(f"{name}.{parameter}: nothing says how well it is known (std; 0 where it is exact)")
    return [*found, *sensor.warnings]
