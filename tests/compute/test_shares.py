"""Every item of a loop that is dealt out in shares is taken once."""

import numpy as np
import pytest

from fusion.compute.language import I32, kernel, ti
from fusion.compute.shares import SHARES, after, dealt, share
from fusion.compute.start import start


@kernel
def _count(taken: I32, total: ti.i32, turn: I32, parts: ti.i32):
    for _ in range(parts):
        n, stop = share(turn, total)
        while n < total:
            taken[n] += 1
            n, stop = after(n, stop, turn, total)


@pytest.mark.parametrize("total", [0, 1, SHARES - 1, SHARES, SHARES + 1, 1000, 99_999])
def test_each_item_is_taken_once(total):
    start()
    taken = np.zeros(total + 1, np.int32)
    _count(taken, total, *dealt())
    assert (taken[:total] == 1).all()
    assert taken[total] == 0
