# mypy: ignore-errors
"""Eight values side by side, written so that the compiler makes vector instructions of them; for kernels."""

from fusion.compute.language import func, ti

LANES = 8


@func
def eight(image: ti.template(), g: ti.i32):
    """Values 8 g to 8 g + 7 of a flat image, read as one vector."""
    return ti.Vector([image[(g << 3) | e] for e in ti.static(range(LANES))])


@func
def bounded(at: ti.i32) -> ti.i32:
    """A place in an image, below 2^28. It changes nothing, but the compiler sees that places around do not overflow;
    else it writes each loop twice, with and without vectors, and looks which one to take every time.

    It also does so where a local array is written to beside an image that is read, once it is used at more than 20
    places of a kernel: from then on it is taken for part of any image. What `eight` reads in four turns is 32 places.
    """
    return at & 0x0FFFFFFF


@func
def put(image: ti.template(), at: ti.i32, values: ti.template()):
    """Writes eight values side by side from a place of a flat image on.

    They are looked at first, in vain: then all places are known before one is written to; else the compiler has to
    suppose that what is written changes where the next one lies, and writes one by one.
    """
    old = ti.Vector([image[at + e] for e in ti.static(range(LANES))])
    new = ti.select(True, values, old)
    for e in ti.static(range(LANES)):
        image[at + e] = new[e]


@func
def gather(image: ti.template(), at: ti.template()):
    """The values at eight places (8,)."""
    return ti.Vector([image[at[e]] for e in ti.static(range(LANES))])


@func
def low(a: ti.template(), b: ti.template()):
    """The smaller one; unlike ti.min not after a look for NaN, which vectors pay for."""
    return ti.select(a < b, a, b)


@func
def high(a: ti.template(), b: ti.template()):
    """The larger one, as `low`."""
    return ti.select(a > b, a, b)


@func
def project(x: ti.template(), y: ti.template(), c: ti.template(), distorted: ti.template()):
    """Pixel (u, v) of x/z and y/z, numbers or vectors, by OpenCV's rational and tangential lens model.

    Args:
        c: fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6.
    """
    a, b = x, y
    if ti.static(distorted):
        q = x * x + y * y
        radial = (1.0 + q * (c[4] + q * (c[5] + q * c[8]))) / (1.0 + q * (c[9] + q * (c[10] + q * c[11])))
        a = x * radial + 2.0 * c[6] * x * y + c[7] * (q + 2.0 * x * x)
        b = y * radial + c[6] * (q + 2.0 * y * y) + 2.0 * c[7] * x * y
    return a * c[0] + c[2], b * c[1] + c[3]
