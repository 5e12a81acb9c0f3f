"""The unit of two surfaces that should have about the same size."""

from dataclasses import replace

import numpy as np

from fusion.mesh.mesh import Mesh

_RATIO = (320.0, 3200.0)  # of sizes: millimetres against metres, even if one shows a third of the other only
_LARGE = 100.0  # [m] both larger than this: no depth camera's metres


def in_metres(mesh: Mesh, reference: Mesh) -> tuple[Mesh, Mesh, tuple[float, float], list[str]]:
    """Both in metres, the factors they were multiplied with (0.001 or 1), and what was recognised, in sentences."""
    sizes = size(mesh), size(reference)
    ratio = sizes[1] / max(sizes[0], 1e-300)
    both = min(sizes) > _LARGE
    factors = [1.0, 1.0]
    notes = []
    for index, (name, larger) in enumerate((("mesh", 1 / max(ratio, 1e-300)), ("reference", ratio))):
        if both or _RATIO[0] < larger < _RATIO[1]:
            factors[index] = 0.001
            notes.append(f"The {name} is in millimetres (its size is {sizes[index]:.4g}); it was converted to metres.")
    last = sizes[0] * factors[0], sizes[1] * factors[1]
    if not 0.1 < last[1] / max(last[0], 1e-300) < 10:
        notes.append(
            f"The sizes differ much, {last[0]:.4g} m and {last[1]:.4g} m: check units, and whether both show the same."
        )
    return _times(mesh, factors[0]), _times(reference, factors[1]), (factors[0], factors[1]), notes


def size(mesh: Mesh) -> float:
    """Diagonal of the box that holds 99 % of the vertices along each axis: a few strays do not count."""
    low, high = np.percentile(mesh.vertices, [0.5, 99.5], axis=0)
    return float(np.linalg.norm(high - low))


def _times(mesh: Mesh, factor: float) -> Mesh:
    return mesh if factor == 1 else replace(mesh, vertices=mesh.vertices * factor)
