"""One file per sensor effect, in rooms by where it acts, and the order in which light meets them."""

from fusion.sensor.effect import Effect
from fusion.sensor.effects.light import LIGHT
from fusion.sensor.effects.optics import OPTICS
from fusion.sensor.effects.phase import PHASE
from fusion.sensor.effects.readout import READOUT
from fusion.sensor.effects.rig import RIG
from fusion.sensor.effects.triangulation import TRIANGULATION

# what stands where, what the lens makes of it, what lights it, how the distance is found, how it is read out
EFFECTS: tuple[type[Effect], ...] = (*RIG, *OPTICS, *LIGHT, *TRIANGULATION, *PHASE, *READOUT)
_PLACES = {kind: float(place) for place, kind in enumerate(EFFECTS)}


def place_of(effect: Effect) -> float:
    """Where in the order an effect acts; one that is not in it stands between what finds a distance and its readout."""
    return _PLACES.get(type(effect), _PLACES[READOUT[0]] - 0.5)
