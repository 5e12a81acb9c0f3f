# mypy: ignore-errors
"""Depth and infrared of a Kinect v2's frame: ten raw images, of which nine count, three phases of three frequencies.

After notes on the protocol that restate OpenKinect's libfreenect2 (its depth equations and constants). Where its
filters write 1.442695 and 0.301030 beside exponentials, natural ones are taken, as its own versions do.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.compute.language import F32_2, F32_3, I32, I32_2, func, kernel, ti
from fusion.compute.start import start
from fusion.devices.kinect_v2.tables import HEIGHT, WIDTH, KinectTables
from fusion.errors import DeviceError

ROW = WIDTH * 11 // 8  # bytes
IMAGE = ROW * HEIGHT  # bytes of one raw image without its footer
SATURATED = 32767
NEAREST, FARTHEST = 500.0, 4500.0  # [mm]
GAINS = (1.322581, 1.0, 1.612903)  # of the three frequencies, 80, 16 and 120 MHz
FAINT, FAINTEST = 3.0, 10.0  # least amplitude of one frequency, and of all together
FILTER = 5.0 * 1.442695  # how quickly a neighbour of another phase counts less
CORNER, EDGE, MIDDLE = 0.1069973, 0.1131098, 0.1195716
UNEVEN = 2.5  # sum of distances to the neighbours from which on a pixel lies on an edge
TURN = 2 * np.pi
THIRDS = [(float(np.cos(k * TURN / 3)), float(np.sin(k * TURN / 3))) for k in range(3)]


@dataclass(frozen=True)
class Decoded:
    """depth (424, 512) float32 [mm], 0 where there is none; infrared (424, 512) float32, 0 to 65535."""

    depth: NDArray[np.float32]
    infrared: NDArray[np.float32]


def decode(images: list[bytes], tables: KinectTables) -> Decoded:
    """Depth and infrared of the ten raw images of one frame, the first pixel the top left one of the picture.

    Raises:
        DeviceError: fewer than nine images, or one of another size.
    """
    sizes = [len(image) for image in images[:9]]
    if len(sizes) < 9 or set(sizes) != {IMAGE}:
        found = f"{len(images)} of {min(sizes, default=0)} bytes and more"
        raise DeviceError("a frame's raw images are not whole", "Kinect v2", found, f"10 of {IMAGE} bytes")
    start()
    shape = (HEIGHT, WIDTH)
    raw = np.zeros((9, IMAGE + 4), np.uint8)
    for place, image in enumerate(images[:9]):
        raw[place, :IMAGE] = np.frombuffer(image, np.uint8)
    words = raw.view("<i4").astype(np.int32, copy=False)
    waves, smooth = np.zeros((*shape, 9), np.float32), np.zeros((*shape, 6), np.float32)
    infrared, total, z, depth = (np.zeros(shape, np.float32) for _ in range(4))
    even = np.zeros(shape, np.int32)
    _measure(words, LEVELS, tables.phase, tables.per_phase, waves, infrared)
    _smooth(waves, smooth, even)
    _range(smooth, tables.x, tables.per_phase, total, z)
    _without_edges(total, z, even, depth)
    return Decoded(np.ascontiguousarray(depth[::-1]), np.ascontiguousarray(infrared[::-1]))


def _levels() -> NDArray[np.int32]:
    """(2048,) what the codes of 11 bits stand for: a sign and steps that grow."""
    steps = np.concatenate([np.ones(256), np.repeat(2.0 ** np.arange(1, 7), 128)])[:1023]
    up = np.concatenate([[0], np.cumsum(steps)])
    levels = np.concatenate([up, -up]).astype(np.int32)
    levels[1024] = SATURATED
    return levels


LEVELS = _levels()


@func
def _code(words: ti.template(), image: ti.i32, x: ti.i32, y: ti.i32):
    """The 11 bits of a pixel: four blocks of 128 in a row, the row itself by halves from the middle."""
    row = ti.select(y < HEIGHT // 2, y + HEIGHT // 2, HEIGHT - 1 - y)
    bit = 11 * ((x >> 2) + 128 * (x & 3)) + 8 * ROW * row
    word, shift = bit >> 5, bit & 31
    code = (words[image, word] >> shift) & ((1 << (32 - shift)) - 1 if shift > 0 else -1)
    if shift > 21:
        code = code | (words[image, word + 1] << (32 - shift))
    return code & 2047


@kernel
def _measure(words: I32_2, levels: I32, phase: F32_3, per_phase: F32_2, waves: F32_3, infrared: F32_2):
    """Cosine and sine of each frequency, then one over their lengths or 0 (424, 512, 9), and the infrared image."""
    for y, x in ti.ndrange(HEIGHT, WIDTH):
        bright = 0.0
        for f in ti.static(range(3)):
            a, b = 0.0, 0.0
            full = False
            turned, across = ti.cos(phase[f, y, x]), ti.sin(phase[f, y, x])
            for k in ti.static(range(3)):
                value = levels[_code(words, 3 * f + k, x, y)]
                if x == 0 or x == WIDTH - 1:
                    value = 0
                full = full or value == SATURATED
                # cosine and sine of the pixel's phase and k thirds of a turn
                a += (turned * ti.static(THIRDS[k][0]) - across * ti.static(THIRDS[k][1])) * value
                b -= (across * ti.static(THIRDS[k][0]) + turned * ti.static(THIRDS[k][1])) * value
            if full or per_phase[y, x] == 0:
                a, b = 0.0, 0.0
            a, b = ti.static(GAINS[f]) * a, ti.static(GAINS[f]) * b
            waves[y, x, 2 * f], waves[y, x, 2 * f + 1] = a, b
            length = ti.sqrt(a * a + b * b)
            waves[y, x, 6 + f] = ti.select(length > 0, 1 / ti.max(length, 1e-20), 0.0)
            bright += ti.select(full, 65535.0, 2 / 3 * length)
        infrared[y, x] = ti.select(per_phase[y, x] == 0, 0.0, ti.min(65535.0, 16 * bright / 3))


@kernel
def _smooth(waves: F32_3, smooth: F32_3, even: I32_2):
    """Each wave averaged over its neighbours of like phase; `even` 1 where they are alike enough."""
    for y, x in ti.ndrange(HEIGHT, WIDTH):
        alike = 1
        for f in ti.static(range(3)):
            a, b = waves[y, x, 2 * f], waves[y, x, 2 * f + 1]
            if 0 < x < WIDTH - 1 and 0 < y < HEIGHT - 1:
                own = waves[y, x, 6 + f]
                most, sharp = ti.static(1 / (FAINT * 1.5)), ti.static(FILTER)
                if own == 0 or own > most:  # a faint pixel takes the plain mean of all
                    most, sharp = 1e30, 0.0
                total, sum_a, sum_b, apart = 0.0, 0.0, 0.0, 0.0
                for dy, dx in ti.static(ti.ndrange((-1, 2), (-1, 2))):
                    c, d = waves[y + dy, x + dx, 2 * f], waves[y + dy, x + dx, 2 * f + 1]
                    other = waves[y + dy, x + dx, 6 + f]
                    if (0 < other <= most) or sharp == 0:
                        distance = 0.5 * (1 - (a * c + b * d) * own * other)
                        near = ti.static((MIDDLE, EDGE, CORNER)[abs(dy) + abs(dx)])
                        weight = near * ti.exp(-sharp * distance)
                        total += weight
                        sum_a += weight * c
                        sum_b += weight * d
                        apart += distance
                a, b = sum_a / ti.max(total, 1e-20), sum_b / ti.max(total, 1e-20)
                if apart >= UNEVEN:
                    alike = 0
            smooth[y, x, 2 * f], smooth[y, x, 2 * f + 1] = a, b
        even[y, x] = alike


@func
def _cycles(smooth: ti.template(), y: ti.i32, x: ti.i32):
    """The three phases in whole cycles and parts of them, each of its own frequency: (3,), and how far they disagree.

    Units of 0.625 m: a cycle of 80 MHz has 3, of 16 MHz 15, of 120 MHz 2.
    """
    t = ti.Vector([0.0, 0.0, 0.0])
    for f in ti.static(range(3)):
        angle = ti.atan2(smooth[y, x, 2 * f + 1], smooth[y, x, 2 * f])
        t[f] = ti.static((3.0, 15.0, 2.0)[f] / TURN) * ti.select(angle < 0, angle + ti.static(TURN), angle)
    fine = 3 * ti.floor((t[1] - t[0]) / 3 + 0.5) + t[0]
    gap = fine - t[2]
    half = ti.abs(gap) / 2
    rest = 2 * (half - ti.floor(half))
    further = ti.select(rest > 0.5 and rest < 1.5, 15.0, 0.0)
    first, second = fine + further, t[1] + further
    third = 0.5 * (2 * ti.floor((first - t[2]) / 2 + 0.5) + t[2])
    return ti.Vector([first / 3, second / 15, third])


@kernel
def _range(smooth: F32_3, across: F32_2, per_phase: F32_2, total: F32_2, z: F32_2):
    """z [mm] of each pixel, 0 where it is too faint or its frequencies disagree, and the sum of its amplitudes."""
    for y, x in ti.ndrange(HEIGHT, WIDTH):
        least, most, both = 1e30, 0.0, 0.0
        for f in ti.static(range(3)):
            amplitude = 2 / 3 * ti.sqrt(smooth[y, x, 2 * f] ** 2 + smooth[y, x, 2 * f + 1] ** 2)
            least, most, both = ti.min(least, amplitude), ti.max(most, amplitude), both + amplitude
        total[y, x] = both
        phase = 0.0
        if least >= FAINT and both >= FAINTEST:
            cycles = _cycles(smooth, y, x)
            off = (ti.static(TURN) * cycles).cross(ti.Vector([0.551318, 0.110264, 0.826977]))
            allowed = ti.exp((ti.log(most) * ti.static(-0.5330578 * 0.301030) + 0.7694894) * 3.321928)
            allowed = ti.min(ti.max(allowed, 0.3490659), 0.6108653)
            if off.norm_sqr() <= allowed * allowed:
                phase = ti.max(cycles.sum() / 3, 0.0)
        found = 0.0
        if phase > 0:
            path, straight = phase * ti.static(2 * 6250 / 3), phase * per_phase[y, x]
            found = straight / (1 - straight * across[y, x] * 90 / (path * path))  # the lamp is 45 mm beside the lens
        z[y, x] = ti.max(found, 0.0)


@kernel
def _without_edges(total: F32_2, z: F32_2, even: I32_2, depth: F32_2):
    """What lies in reach and is no mixture of near and far at an edge."""
    for y, x in ti.ndrange(HEIGHT, WIDTH):
        here = z[y, x]
        if here < NEAREST or here > FARTHEST:
            here = 0.0
        if here > 0 and 0 < x < WIDTH - 1 and 0 < y < HEIGHT - 1:
            some, squares, low, high = 0.0, 0.0, here, here
            for dy, dx in ti.static(ti.ndrange((-1, 2), (-1, 2))):
                s, beside = total[y + dy, x + dx], z[y + dy, x + dx]
                some += s
                squares += s * s
                if even[y + dy, x + dx] == 1 and beside > 0:
                    low, high = ti.min(low, beside), ti.max(high, beside)
            spread = ti.sqrt(ti.max(9 * squares - some * some, 0.0)) / 9 / ti.max(some / 9, 50.0)
            near, far = here - low, high - here
            if spread >= 0.05 and near > 50 and far > 30 and ti.max(near, far) > 100:
                here = 0.0
            if even[y, x] == 0:
                here = 0.0
        depth[y, x] = here
