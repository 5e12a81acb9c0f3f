"""Raw images of a Kinect v2 that would look at a scene: a forward model from notes on the protocol, written apart.

A lamp 45 mm right of the lens, light there and back, three frequencies at three phases each, sign and steps in 11 bits,
and these bits in their places. Nothing of it is the decoder's; lengths in metres.
"""

import numpy as np

C, HERTZ = 3e8, (80e6, 16e6, 120e6)
GAIN = (1.322581, 1.0, 1.612903)
LAMP = 0.045
W, H = 512, 424


def rays(fx, fy, cx, cy, k1=0.0, k2=0.0, p1=0.0, p2=0.0, k3=0.0):
    """(424, 512) x and y of rays with z = 1, by fixed-point steps."""
    xd, yd = np.meshgrid((np.arange(W) + 0.5 - cx) / fx, (np.arange(H) + 0.5 - cy) / fy)
    x, y = xd, yd
    for _ in range(200):
        r2 = x * x + y * y
        radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
        x, y = (
            (xd - p2 * (r2 + 2 * x * x) - 2 * p1 * x * y) / radial,
            (yd - p1 * (r2 + 2 * y * y) - 2 * p2 * x * y) / radial,
        )
    return x, y


def path(z, x, y):
    """Of light from the lamp to a point and back to the lens."""
    point = np.stack([z * x, z * y, z], axis=-1)
    return np.linalg.norm(point - [LAMP, 0, 0], axis=-1) + np.linalg.norm(point, axis=-1)


def measured(z, x, y, amplitude, p0):
    """(9, 424, 512) what the pixels measure; p0 (3, 424, 512) uint16."""
    light = path(z, x, y)
    out = []
    for f in range(3):
        delay = 2 * np.pi * HERTZ[f] * light / C
        for k in range(3):
            angle = -0.000031 * np.pi * p0[f] + k * 2.094395
            out.append(amplitude / GAIN[f] * np.cos(angle + delay))
    return np.stack(out)


def codes(values):
    """The nearest of the 1023 steps up or down."""
    level, levels = 0, [0]
    for code in range(1023):
        level += 1 if code < 256 else 2 ** (1 + (code - 256) // 128)
        levels.append(level)
    assert level == 16320
    levels = np.array(levels)
    middles = (levels[1:] + levels[:-1]) / 2
    size = np.searchsorted(middles, np.abs(values))
    return np.where((values < 0) & (size > 0), 1024 + size, size)


def packed(code):
    """Bytes of one raw image from its codes (424, 512), bit by bit."""
    bits = np.zeros((H, W * 11), np.uint8)
    for x in range(W):
        begin = 11 * (x // 4 + 128 * (x % 4))
        for bit in range(11):
            bits[:, begin + bit] = (code[:, x] >> bit) & 1
    rows = np.zeros_like(bits)
    for y in range(H):
        rows[y + 212 if y < 212 else 423 - y] = bits[y]
    return np.packbits(rows, axis=1, bitorder="little").tobytes()


def frame(z, x, y, amplitude, p0, saturated=None):
    """The ten raw images; `saturated` (424, 512) pixels that had too much light."""
    images = []
    for value in measured(z, x, y, amplitude, p0):
        code = codes(value)
        if saturated is not None:
            code = np.where(saturated, 1024, code)
        images.append(packed(code))
    return [*images, bytes(len(images[0]))]


def phase_tables(p0):
    """Reply 0x02: p0 (3, 424, 512) uint16 for the rows of the sub-images."""
    head = np.array([32, 0, 0, 2 * W * H, 0, 0, 0, 0], "<u4").tobytes()
    each = [b"\x01\x00" + table[::-1].astype("<u2").tobytes() + b"\x02\x00" for table in p0]
    return head + b"".join(each)


def camera_parameters(fx, fy, cx, cy, *bent):
    """Reply 0x03."""
    values = np.zeros(23, "<f4")
    values[: 5 + len(bent)] = [fx, fy, 0, cx, cy, *bent]
    return values.tobytes()
