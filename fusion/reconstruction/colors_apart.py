"""Colour images that do not belong to the depth: what they show moves otherwise than the surfaces do."""

from fusion.results.light import Light

CHECK = "See that colour is of the same moment, not mirrored and in the depth's pixels: it is wrong on the mesh, too."


def colors_apart(missed: float) -> Light:
    """A warning, from squares by which landmarks miss everything else over what they state."""
    told = f"Landmarks of the colour images miss the surfaces by {missed**0.5:.1f} times what they may: "
    told += "colour and depth do not belong together, and tracking left colour out."
    return Light("warning", "Colour", told, CHECK)
