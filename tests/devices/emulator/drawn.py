"""What the emulated camera looks at: raw values as a function of pixel and frame number, and the same packed as bytes.

The picture rolls upwards by one row a frame: row v of frame n shows row (v + n) mod H of the drawing. A test that knows
these formulas knows every value of every frame:

    depth(u, y)    11 bit, H = 480: 2047 (no value) where u >= 632 or (400 <= u < 440 and 200 <= y < 240);
                   500 + (u - 200) // 4 where 200 <= u < 360 and 120 <= y < 300 (a near box);
                   700 + u // 8 + y // 16 elsewhere (a wall that recedes)
    bayer(u, y)     8 bit, H = 480: on even rows of the IMAGE (v, not y) G R G R ..., on odd rows B G B G ..., with
                   R = u // 4, G = y // 2, B = 200 where 200 <= u < 360 and 120 <= y < 300, else 40
    infrared(u, y) 10 bit, H = 488: 100 + u + y // 4
"""

WIDTH = 640


def depth(u: int, y: int) -> int:
    if u >= 632 or (400 <= u < 440 and 200 <= y < 240):
        return 2047
    if 200 <= u < 360 and 120 <= y < 300:
        return 500 + (u - 200) // 4
    return 700 + u // 8 + y // 16


def bayer(u: int, y: int, v: int) -> int:
    if (u + v) % 2 == 0:
        return y // 2
    if v % 2 == 0:
        return u // 4
    return 200 if 200 <= u < 360 and 120 <= y < 300 else 40


def infrared(u: int, y: int) -> int:
    return 100 + u + y // 4


def packed(values: list[int], bits: int) -> bytes:
    """One big-endian stream of bits, the most significant first; 640 values of 10 or 11 bits end on a byte."""
    total = 0
    for value in values:
        total = total << bits | value
    return total.to_bytes(len(values) * bits // 8, "big")


class Roll:
    """The bytes of any frame: a window into rows that stand twice below each other."""

    def __init__(self, rows: list[bytes]) -> None:
        self.height, self.row_bytes = len(rows), len(rows[0])
        self._twice = b"".join(rows) * 2

    def frame(self, number: int) -> bytes:
        first = number % self.height * self.row_bytes
        return self._twice[first : first + self.height * self.row_bytes]


class BayerRoll:
    """The same for Bayer: which colour a pixel has is of the image, so odd frames have rows of their own."""

    def __init__(self) -> None:
        self._rolls = [Roll([_bayer_row(y, y + shift) for y in range(480)]) for shift in (0, 1)]

    def frame(self, number: int) -> bytes:
        return self._rolls[number % 2].frame(number)


def _bayer_row(y: int, v: int) -> bytes:
    return bytes(bayer(u, y, v) for u in range(WIDTH))


def depth_roll() -> Roll:
    return Roll([packed([depth(u, y) for u in range(WIDTH)], 11) for y in range(480)])


def infrared_roll() -> Roll:
    return Roll([packed([infrared(u, y) for u in range(WIDTH)], 10) for y in range(488)])
