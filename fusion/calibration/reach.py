"""Reach: how far a number may move before the data object, for numbers where a slope says nothing."""

from collections.abc import Callable

SHORTEST = 1e-6  # [of the number's unit] first step; a spread of 1 micrometre or a millionth of a pixel is nothing
GROWTH = 1.2  # from one step to the next: the reach is known to a fifth


def reach(cost: Callable[[float], float], room: float, first: float = SHORTEST) -> float:
    """How far a number moves from where it is until `cost` has grown by 1; `room` where it never does.

    The square of a number that has come to 0 has no slope there, and by its slope the number would seem to be anything.

    Args:
        cost: growth of the chi2 when the number has moved by so much.
        room: the most that it may move.
        first: step to begin with.
    """
    moved = first
    while moved < room:
        if cost(moved) >= 1.0:
            return moved
        moved *= GROWTH
    return room
