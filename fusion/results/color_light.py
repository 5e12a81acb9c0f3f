"""What a person should know of the colours of a mesh."""

from fusion.coloring.color_mesh import Colored
from fusion.results.light import Light

CHECK = "See that colour is of the same moment, not mirrored and in the depth's pixels: it is wrong on the mesh, too."


def color_lights(colored: Colored) -> tuple[Light, ...]:
    """One light where images could not be used, else none."""
    if not colored.lost:
        return ()
    text = f"{colored.lost} of {colored.images + colored.lost} colour images that were asked for could not be used."
    return (Light("warning", "Colour", text, "`fusion info` names damaged files."),)


def colors_apart(missed: float) -> Light:
    """Colour images that show another motion than the surfaces do.

    Args:
        missed: squares by which their landmarks miss everything else, over what they state.
    """
    told = f"Landmarks of the colour images miss the surfaces by {missed**0.5:.1f} times what they may: "
    told += "colour and depth do not belong together, and tracking left colour out."
    return Light("warning", "Colour", told, CHECK)
