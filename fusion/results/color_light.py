"""What a person should know of the colours of a mesh."""

from fusion.coloring.color_mesh import Colored
from fusion.results.light import Light


def color_lights(colored: Colored) -> tuple[Light, ...]:
    """One light where images could not be used, else none."""
    if not colored.lost:
        return ()
    text = f"{colored.lost} of {colored.images + colored.lost} colour images that were asked for could not be used."
    return (Light("warning", "Colour", text, "`fusion info` names damaged files."),)
