"""What a pixel measures when part of its light comes from across a depth edge."""

import numpy as np

from fusion.sensor.laws.phasor import two_paths
from fusion.sensor.view import Image, View


def mixed(share: Image, depth: Image, view: View) -> tuple[Image, Image]:
    """Depth and amplitude when `share` (h, w) of what a pixel sees lies across its nearest edge.

    Both sides count by their amplitude. Time of flight adds phasors, so that the result may lie outside the two
    depths; any other sensor takes the mean. Nothing changes where the share is 0 or there is no edge.

    Returns:
        The change of the depth (h, w) [m], and what the amplitude is multiplied by (h, w) [1].
    """
    change, growth = np.zeros_like(depth), np.ones_like(depth)
    if view.edges is None:
        return change, growth
    where = np.nonzero((share > 0) & np.isfinite(depth) & np.isfinite(view.edges.jump) & (view.edges.jump != 0))
    jump, light, part = (np.asarray(a[where], depth.dtype) for a in (view.edges.jump, view.edges.light, share))
    own, other = 1 - part, part * np.nan_to_num(np.maximum(light, 0), nan=1.0)
    if view.time_of_flight:
        stretch = view.stretch[where]
        longer, growth[where] = two_paths(own, other, jump * stretch, view)
        change[where] = longer / stretch
    else:
        growth[where] = own + other
        change[where] = jump * other / np.maximum(own + other, np.finfo(depth.dtype).tiny)
    return change, growth
