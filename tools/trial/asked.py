"""What an answer asks to be recorded next, as one of the kinds of recording that can be made here."""

# words of an answer, in the order in which they decide when they stand at the same place
WORDS = {
    "warm rail": ("warm-up rail",),
    "time": ("warm-up", "temperature", "warm", "cold", "time"),
    "light": ("amplitude switch", "exposure", "lamp"),
    "card": ("near card", "white card"),
    "cloth": ("corner", "cloth"),
    "step": ("step", "two depths", "two distances", "board half", "stair"),
    "patches": ("patch", "reflectance", "material", "amplitude", "black", "grey"),
    "rail": ("rail", "laser"),
    "roll": ("rolled", "about its axis"),
    "tilt": ("tilt", "incidence", "45 degrees"),
    "distance": ("distance", "depth", "range", "disparity", "farther", "nearer"),
}


def kind_asked(text: str) -> str | None:
    """The kind whose word comes first; None when the answer asks for nothing that can be made."""
    found = [(text.lower().find(word), kind) for kind, words in WORDS.items() for word in words]
    return min((entry for entry in found if entry[0] >= 0), key=lambda entry: entry[0], default=(0, None))[1]
