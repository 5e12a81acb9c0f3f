"""What an answer asks to be recorded next, as one of the kinds of recording that can be made here."""

# words of an answer, in the order in which they decide when they stand at the same place
WORDS = {
    "step": ("two depths", "two distances", "step", "stair"),
    "patches": ("reflectance", "material", "amplitude", "patch", "black", "dark", "bright", "grey"),
    "time": ("temperature", "time", "warm", "cold", "minutes"),
    "tilt": ("tilt", "incidence", "turned", "rolled", "roll", "radius"),
    "distance": ("depth", "distance", "range", "disparity", "farther", "nearer", "rail"),
}


def kind_asked(text: str) -> str | None:
    """The kind whose word comes first; None when the answer asks for nothing that can be made."""
    found = [(text.lower().find(word), kind) for kind, words in WORDS.items() for word in words]
    return min(((place, kind) for place, kind in found if place >= 0), default=(0, None))[1]
