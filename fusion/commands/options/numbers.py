"""Options that take a number: what is possible stands in `fusion.quantity`, and is asked before any work."""

from collections.abc import Callable

from fusion.quantity import Quantity


def number(quantity: Quantity) -> Callable[[str], float]:
    """Reads a number that is possible; what is none is wrong usage, what is not possible a FusionError."""

    def read(text: str) -> float:
        value = float(text)
        quantity.check(value)
        return value

    read.__name__ = "number"  # as argparse names it: invalid number value
    return read


def whole_number(quantity: Quantity) -> Callable[[str], int]:
    """The same for numbers without a fraction."""

    def read(text: str) -> int:
        value = int(text)
        quantity.check(value)
        return value

    read.__name__ = "whole number"
    return read
