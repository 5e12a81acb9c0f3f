"""What a pixel measures when part of its light comes from across a depth edge."""

import numpy as np

from fusion.sensor.view import Image, View


def mixed(share: Image, depth: Image, view: View) -> Image:
    """Change (h, w) [m] of the depth when `share` (h, w) of what a pixel sees lies across its nearest edge.

    Both sides count by their amplitude. Time of flight adds phasors, so that the result may lie outside the two
    depths; any other sensor takes the mean. 0 where the share is 0 or there is no edge.
    """
    change = np.zeros_like(depth)
    if view.edges is None:
        return change
    where = np.nonzero((share > 0) & np.isfinite(depth) & np.isfinite(view.edges.jump) & (view.edges.jump != 0))
    jump, light, part = (np.asarray(a[where], depth.dtype) for a in (view.edges.jump, view.edges.light, share))
    own, other = 1 - part, part * np.nan_to_num(np.maximum(light, 0), nan=1.0)
    if not view.time_of_flight:
        # a side without light leaves the other; both without leave the depth
        total = own + other
        change[where] = jump * other / np.where(total > 0, total, 1)
        return change
    stretch = view.stretch[where]
    turn = 2 * np.pi * jump * stretch / view.wavelength  # phase of the other side before the own
    phase = np.arctan2(other * np.sin(turn), own + other * np.cos(turn))
    change[where] = phase * view.wavelength / (2 * np.pi * stretch)
    return change
