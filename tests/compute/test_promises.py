"""A device is asked whether it holds to what kernels rely on; a processor does, and what does not is named."""

import numpy as np
import pytest

from fusion.compute.cards import promises
from fusion.compute.start import start


def test_a_processor_holds_to_all_of_it():
    start()
    assert promises.broken_promise() == ""


def garbage(values, every, bits, wide, count):
    every[1::2] = 1e9


def wrong_sums(values, every, bits, wide, count):
    every[::2] += 1e-3


def numbers_for_nan(values, every, bits, wide, count):
    bits[np.isnan(values)] = 0


def cut_bits(values, every, bits, wide, count):
    bits[bits != -1] &= ~1


def short(values, every, bits, wide, count):
    wide &= 0xFFFFFFFF


def uncounted(values, every, bits, wide, count):
    count[0] -= 1


def unlike(values, every, bits, wide, count):
    count[1] -= 1


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (garbage, "unwritten"),
        (wrong_sums, "sums"),
        (numbers_for_nan, "NaN"),
        (cut_bits, "bits of numbers"),
        (short, "64 bits"),
        (uncounted, "count"),
        (unlike, "unlike length"),
    ],
)
def test_a_device_that_breaks_one_is_found(spoil, told):
    start()

    def spoiled(*arrays):
        promises.trial(*arrays)
        spoil(*arrays)

    assert told in promises.broken_promise(spoiled)
