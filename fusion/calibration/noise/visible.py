"""Which numbers of the axial law a grid of poses can show, and what to record for the others."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.noise.laws.axial_forms import Places
from fusion.geometry.principle import Principle

APART = 0.06  # share of the depth: nearer ones are one distance
STEEP = np.deg2rad(40)  # below it the angle term is a few per cent of the noise
RATIO = 1.4  # farthest over nearest distance of tilted targets that tell the power of z
SUNNY_LUX, SUNNY = 15_000.0, 0.006  # [lux]; [1/m] noise over z^2 that no room makes: four times the overcast law's


@dataclass(frozen=True)
class VisibleParameters:
    """Parameters of axial_noise that can be seen, and for those that cannot what to record."""

    seen: frozenset[str]
    hidden: dict[str, str]


def visible(
    places: Places, sigma: NDArray[np.floating], lux: NDArray[np.floating], principle: Principle
) -> VisibleParameters:
    """Judge the places (n,) with their noise [m] and the stated light [lux], NaN where it is not stated."""
    distances, seen, hidden = count_apart(places.depth), {"c0"}, {}
    ways = "a target at six or more distances from the nearest to the farthest in use"
    numbers = len(places.depth)
    if distances >= 3 and numbers >= 5:
        seen |= {"c1", "c2"}
    elif distances == 2 and numbers >= 3:
        seen |= {"c2"}
        hidden["c1"] = f"{ways} (these are at 2)"
    else:
        hidden |= dict.fromkeys(("c1", "c2"), f"{ways} (these are at {distances})")
    steep = places.tilt >= STEEP
    if steep.any() and numbers >= len(seen) + 2:
        seen.add("angle")
        z = places.depth[steep]
        if count_apart(z) >= 2 and np.max(z) > RATIO * np.min(z):
            seen.add("angle_exponent")
        else:
            hidden["angle_exponent"] = "the target turned to 60 and 75 deg at a near and at a far distance"
    else:
        most = float(np.rad2deg(np.max(places.tilt)))
        hidden["angle"] = (
            f"the target turned to 45, 60 and 75 deg at two or more distances (at most {most:.0f} deg now)"
        )
    sunny = np.nanmax(lux, initial=0.0) > SUNNY_LUX or float(np.median(sigma / places.depth**2)) > SUNNY
    if principle == Principle.TIME_OF_FLIGHT and sunny:
        if {"c2", "angle"} <= seen and count_apart(1.0 + places.tilt) >= 3:
            seen.add("sunlight")
        else:
            hidden["sunlight"] = "the target in the sun at three or more angles from 0 to 75 deg"
    return VisibleParameters(frozenset(seen), hidden)


def count_apart(values: NDArray[np.floating]) -> int:
    """How many values there are that differ by more than 6 %."""
    ordered = np.sort(values)
    return int(1 + (np.diff(ordered) > APART * ordered[:-1]).sum()) if len(values) else 0
