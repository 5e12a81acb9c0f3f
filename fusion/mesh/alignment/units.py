"""The unit of two surfaces that should have about the same size."""

from dataclasses import replace

import numpy as np

from fusion.errors import MeshError
from fusion.mesh.mesh import Mesh

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}  # [m]
_NAMES = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "inch": "inches"}
# of the sizes, in that unit and in metres. Millimetres stand alone: one may show a third of the other only.
# Centimetres and inches are 2.5 apart: told only where the other one would need a part or a plate of twice the size
_RATIOS = {"mm": (320.0, 3200.0), "cm": (80.0, 200.0), "inch": (25.0, 49.0)}
_SMALL = 0.005  # [m] no object of a depth camera
_WIDE = 10.0  # [m] a hall, or something small in millimetres
LARGE = 100.0  # [m] both larger than this: no depth camera's metres


def in_metres(
    mesh: Mesh, reference: Mesh, unit: str | None = None
) -> tuple[Mesh, Mesh, tuple[float, float], list[str]]:
    """Both in metres, the factors they were multiplied with, and what was recognised, in sentences.

    Args:
        unit: of the reference, one of `UNITS`; None: told from the sizes.

    Raises:
        MeshError: no such unit, or one that makes the reference smaller than any depth camera sees.
    """
    if unit is not None and unit not in UNITS:
        raise MeshError("unknown unit of the reference", "unit", unit, " or ".join(UNITS))
    factors = [1.0, UNITS[unit or "m"]]
    sizes = [size(mesh), size(reference) * factors[1]]
    ratio = max(sizes[1], 1e-300) / max(sizes[0], 1e-300)
    if unit is not None and sizes[1] < _SMALL:
        raise MeshError(
            "the reference is too small in its stated unit",
            "--unit",
            f"{unit}, so {1e3 * sizes[1]:.3g} mm; the mesh is {sizes[0]:.3g} m",
            f"{1e3 * _SMALL:g} mm or more",
            "without --unit it is told from the sizes",
        )
    notes = []
    both_mm = unit is None and min(sizes) > LARGE
    for index, (name, larger) in enumerate((("mesh", 1 / ratio), ("reference", ratio))):
        stated = unit is not None and name == "reference"
        found = None if stated else "mm" if both_mm else _unit(larger)
        if found:
            factors[index] = UNITS[found]
            do = " If that is wrong, name its unit with --unit." if name == "reference" else ""
            other = "reference" if name == "mesh" else "mesh"
            beside = "" if both_mm else f", that of the {other} {sizes[1 - index]:.4g}"
            notes.append(
                f"The {name} looks like {_NAMES[found]}: its size is {sizes[index]:.4g}{beside}; it was multiplied by "
                f"{UNITS[found]:g}.{do}"
            )
            sizes[index] *= UNITS[found]
    last = sizes[0], sizes[1]
    if not 0.1 < last[1] / max(last[0], 1e-300) < 10:
        notes.append(
            f"The sizes differ much, {last[0]:.4g} m and {last[1]:.4g} m, and do not tell a unit: check that both "
            f"show the same; if the reference is not in metres, name its unit with --unit ({', '.join(UNITS)})."
        )
    elif unit is None and factors == [1.0, 1.0] and min(last) > _WIDE:
        notes.append(
            f"Both were taken as metres, {last[0]:.4g} m and {last[1]:.4g} m from end to end; if they are not, name "
            f"the reference's unit with --unit ({', '.join(UNITS)}): the mesh follows it."
        )
    return times(mesh, factors[0]), times(reference, factors[1]), (factors[0], factors[1]), notes


def size(mesh: Mesh) -> float:
    """Diagonal of the box that holds 99 % of the vertices along each axis: a few strays do not count."""
    low, high = np.percentile(mesh.vertices, [0.5, 99.5], axis=0)
    return float(np.linalg.norm(high - low))


def _unit(larger: float) -> str | None:
    """The unit of what is so many times larger than the other one, which is in metres; None: metres, or unclear."""
    return next((unit for unit, (low, high) in _RATIOS.items() if low < larger < high), None)


def times(mesh: Mesh, factor: float) -> Mesh:
    """The mesh, so many times as large."""
    return mesh if factor == 1 else replace(mesh, vertices=mesh.vertices * factor)
