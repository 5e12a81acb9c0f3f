"""The facts of a scan in words, the same on the terminal and on the page."""

import numpy as np

from fusion.certainty.sigma import without_words
from fusion.mesh.shape import MeshShape
from fusion.results.facts import Gap, SureFacts, TableFacts

LARGE = 2.0  # [m] what is longer is told in metres


def size_words(shape: MeshShape) -> tuple[str, str]:
    """(number, unit) of width, depth and height: ("134 x 133 x 169", "mm")."""
    if max(shape.size) > LARGE:
        return " x ".join(f"{side:.2f}" for side in shape.size), "m"
    return " x ".join(f"{side * 1e3:.0f}" for side in shape.size), "mm"


def volume_words(shape: MeshShape) -> tuple[str, str] | None:
    """(number, unit) of the volume: ("812", "cm3"), ("2.41", "litres"); None where it is not known."""
    if shape.volume is None:
        return None
    cubic_cm = shape.volume * 1e6
    if cubic_cm < 1000:
        return (f"{cubic_cm:.0f}" if cubic_cm >= 10 else f"{cubic_cm:.2g}"), "cm3"
    return (f"{cubic_cm / 1e3:.2f}", "litres") if cubic_cm < 1e6 else (f"{shape.volume:.2f}", "m3")


def mesh_words(shape: MeshShape) -> str:
    """ "134 x 133 x 169 mm, 2.41 litres, bottom open, 3 holes, 162,836 triangles"."""
    volume = volume_words(shape)
    parts = [" ".join(size_words(shape)), *([" ".join(volume)] if volume else []), shape.openings()]
    parts += [f"{shape.fragments:,} parts"] if shape.fragments > 1 else []
    return ", ".join([*parts, f"{shape.triangles:,} triangles"])


def hidden_words(table: TableFacts) -> str:
    """ "the lowest 1.6 mm cannot be told from the plate: the sides are carried down to it"."""
    return f"the lowest {table.hidden * 1e3:.1f} mm cannot be told from the plate: the sides are carried down to it"


def step_words(table: TableFacts) -> tuple[str, str]:
    """Mean and standard deviation of the steps [deg]: ("15.63", "1.38")."""
    return f"{np.rad2deg(table.step_mean):.2f}", f"{np.rad2deg(table.step_std):.2f}"


def table_words(table: TableFacts) -> str:
    """ "15.63 deg a frame (std 1.38), no slip"."""
    slips = ", ".join(f"slip before frame {frame}" for frame in table.slips) or "no slip"
    mean, std = step_words(table)
    rests = f"; in {table.rests} frames it stands as in the one before (frames there twice?)" if table.rests else ""
    return f"{mean} deg a frame (std {std}), {slips}{rests}"


def gap_words(gap: Gap) -> str:
    """ "2.49 mm, 0.41 deg"."""
    return f"{gap.distance * 1e3:.2f} mm, {np.rad2deg(gap.angle):.2f} deg"


def closing_words(table: TableFacts) -> str:
    """The closing gap, and whether the post-pass made it better or worse."""
    if table.gap is None:
        return "no full turn"
    said = f"closing gap {gap_words(table.gap)}"
    if table.gap_raw is None:
        return said
    worse = worse_words(table)
    return f"{said} ({worse})" if worse else f"{said} ({gap_words(table.gap_raw)} before the post-pass)"


def worse_words(table: TableFacts) -> str:
    """What of the closing gap got worse by the post-pass, as far as the printed digits tell; "" when nothing did."""
    if table.gap is None or table.gap_raw is None:
        return ""
    pairs = [
        (np.rad2deg(table.gap_raw.angle), np.rad2deg(table.gap.angle), "deg"),
        (table.gap_raw.distance * 1e3, table.gap.distance * 1e3, "mm"),
    ]
    worse = [f"{old:.2f} to {new:.2f} {unit}" for old, new, unit in pairs if round(new, 2) > round(old, 2)]
    return f"worse than before the post-pass: {', '.join(worse)}" if worse else ""


def sure_words(sure: SureFacts) -> str:
    """ "0.21 mm (median; 95 % below 0.58 mm), of which calibration 0.06 mm"."""
    said = f"{1e3 * sure.middle:.2f} mm (median; 95 % below {1e3 * sure.high:.2f} mm)"
    if sure.common is not None:
        said += f", of which calibration {1e3 * sure.common:.2f} mm"
    return f"{said}, {without_words(sure.unknown)}" if sure.unknown else said
