# mypy: ignore-errors
"""All edges of a joint fit on Taichi: pairs, residuals and derivatives, errors of the camera included; their sums."""

from typing import NamedTuple

from fusion.compute.language import F32, F32_2, F32_3, F64, F64_2, F64_3, I32, I32_2, func, kernel, ti
from fusion.compute.shares import SPLIT
from fusion.geometry.lanes import project
from fusion.geometry.robust import CUT
from fusion.turntable.selfcheck import DEPTH

F32_4 = ti.types.ndarray(ti.f32, 4)
I8_2 = ti.types.ndarray(ti.i8, 2)
vec3 = ti.types.vector(3, ti.f32)
ERRORS = len(DEPTH)
terms_type = ti.types.vector(ERRORS, ti.f32)
BLOCK = 64  # points
COLUMNS = 5 + 3 + ERRORS  # derivatives of a pair
NOWHERE = -1  # as a pixel
HIDDEN, SEEN, PAIRED = 0, 1, 2  # the model's camera cannot tell; sees the place, and no partner there; a pair


class PairedViews(NamedTuple):
    """Pairs of views and the views themselves."""

    edges: I32_2  # (m, 2) source and model view
    poses: F32_3  # (m, 4, 4) model from source
    first: I32  # (n + 1,) where the points of each view start
    sources: F32_2  # (all, 7) point, normal, sigma
    maps: F32_4  # (n, h, w, 7) the same of every view's pixels


class CameraErrors(NamedTuple):
    """A camera and what is wrong with it."""

    lens: F32  # (12,) the corrected camera, see `geometry/lanes.py`
    stated: F32  # (2,) fx, fy as stated
    check: F32  # (13,) errors of camera and depth
    span: F32  # (4,) near, far [m], 1 for triangulation, 0 without depth errors


@func
def depth_terms(p: ti.template(), span: ti.template()):
    """Depth errors at a point per unit of each (see `SelfCheck`)."""
    s = ti.math.clamp((2.0 * p[2] - span[0] - span[1]) / (span[1] - span[0]), -1.0, 1.0)
    x, y = p[0] / p[2], p[1] / p[2]
    growing = (2.0 * p[2] / (span[0] + span[1])) ** 2 if span[2] > 0.0 else 1.0
    terms = terms_type(1.0, growing * (x * x + y * y), growing * x, growing * y, s, 0.0, 0.0, 0.0, 0.0, 0.0)
    before, now = 1.0, s
    for k in ti.static(range(1, 6)):  # Bonnet's recursion
        after = ((2.0 * k + 1.0) * s * now - k * before) / (k + 1.0)
        terms[k + 4] = after
        before, now = now, after
    return terms


@func
def _corrected(x: ti.f32, y: ti.f32, stated: ti.f32, camera: ti.template()):
    """A point with the errors of camera and depth taken out."""
    check = ti.static(camera.check)
    p, z = vec3(x, y, stated), stated
    if camera.span[3] > 0.0:
        terms = depth_terms(p, camera.span)
        for k in ti.static(range(ERRORS)):
            z += terms[k] * check[3 + k]
    right = (p[0] / p[2] * camera.stated[0] - check[1]) / camera.lens[0] * z
    down = (p[1] / p[2] * camera.stated[1] - check[2]) / camera.lens[1] * z
    return vec3(right, down, z)


@func
def _along(p: ti.template(), d: ti.template(), camera: ti.template()):
    """Change (3,) of a point along a direction per unit of focal length and principal point."""
    return vec3(-(d[0] * p[0] + d[1] * p[1]), -d[0] * p[2] / camera[0], -d[1] * p[2] / camera[1])


@func
def _by_axis(
    out: ti.template(), e: ti.i32, k: ti.i32, q: ti.template(), n: ti.template(), R: ti.template(), axis: ti.template()
):
    """Derivatives of a pair's residual in its turn, and in tilts and shifts of the axis; the normal before the turn."""
    arm = q - vec3(axis[0, 0], axis[0, 1], axis[0, 2])
    before, turned = R.transpose() @ arm, R.transpose() @ n
    out[e, k, 2] = n.dot(vec3(axis[1, 0], axis[1, 1], axis[1, 2]).cross(arm))
    for s in ti.static(range(2)):
        across = vec3(axis[2 + s, 0], axis[2 + s, 1], axis[2 + s, 2])
        out[e, k, 3 + s] = n.dot(across.cross(arm)) - turned.dot(across.cross(before))
        out[e, k, 5 + s] = (n - turned).dot(across)
    return turned


@func
def _by_camera(
    out: ti.template(), e: ti.i32, k: ti.i32, p: ti.template(), turned: ti.template(), there: ti.template(),
    n: ti.template(), camera: ti.template(),
):  # fmt: skip
    """The same in errors of camera and depth, those that `out` has columns for."""
    lenses = _along(p, turned, camera.lens) - _along(there, n, camera.lens)
    for s in ti.static(range(3)):
        if out.shape[2] > 7 + s:
            out[e, k, 7 + s] = lenses[s]
    if out.shape[2] > 10:
        change = turned.dot(p) / p[2] * depth_terms(p, camera.span)
        change -= n.dot(there) / there[2] * depth_terms(there, camera.span)
        for s in ti.static(range(ERRORS)):
            if out.shape[2] > 10 + s:
                out[e, k, 10 + s] = change[s]


@func
def _find_pixels(
    out: ti.template(), R: ti.template(), t: ti.template(), begin: ti.i32, end: ti.i32, sources: ti.template(),
    maps: ti.template(), camera: ti.template(), limits: ti.template(),
):  # fmt: skip
    """In which pixel of a map points lie, NOWHERE outside.

    What lies there is looked up in a loop of its own: so short a one has many under way, and memory answers while it
    goes on.
    """
    for k in range(end):
        at = begin + k
        q = R @ _corrected(sources[at, 0], sources[at, 1], sources[at, 2], camera) + t
        x, y = project(q[0] / q[2], q[1] / q[2], ti.static(camera.lens), True)
        u, v = ti.floor(x / limits[2] + 0.5, ti.i32), ti.floor(y / limits[2] + 0.5, ti.i32)
        inside = (q[2] > 0.05) & (u >= 0) & (u < maps.shape[2]) & (v >= 0) & (v < maps.shape[1])
        out[k] = ti.select(inside, v * maps.shape[2] + u, NOWHERE)


@kernel
def pair_edges(
    views: PairedViews,
    camera: CameraErrors,
    axis: F32_2,  # (4, 3) point, direction, the two across
    limits: F32,  # (3,) reach [m], least cosine, pixels between those of `maps`
    code: I8_2,  # (m, most) out
    out: F32_3,  # (m, most, 7 to 20) out, of pairs: residual, sigma, derivatives
):
    """What becomes of each point of each edge's source."""
    edges, poses, first, maps = ti.static((views.edges, views.poses, views.first, views.maps))
    sources = ti.static(views.sources)
    for part in range(edges.shape[0] * SPLIT):
        if part % SPLIT == 0:
            e = part // SPLIT
            i, j = edges[e, 0], edges[e, 1]
            R = ti.Matrix([[poses[e, r, c] for c in ti.static(range(3))] for r in ti.static(range(3))])
            t = vec3(poses[e, 0, 3], poses[e, 1, 3], poses[e, 2, 3])
            at_pixel, sigma = ti.Vector([0] * BLOCK), ti.Vector([0.0] * BLOCK)
            width, begin, points = maps.shape[2], first[i], first[i + 1] - first[i]
            for block in range((code.shape[1] + BLOCK - 1) // BLOCK):
                rest = block * BLOCK
                end = ti.max(ti.min(BLOCK, points - rest), 0)
                _find_pixels(at_pixel, R, t, begin + rest, end, sources, maps, camera, limits)
                for k in range(ti.min(BLOCK, code.shape[1] - rest)):
                    code[e, rest + k] = ti.cast(HIDDEN, ti.i8)
                for k in range(end):
                    if at_pixel[k] > NOWHERE:
                        v, u = at_pixel[k] // width, at_pixel[k] % width
                        sigma[k] = maps[j, v, u, 6]
                        if maps[j, v, u, 2] > 0.0:
                            code[e, rest + k] = ti.cast(SEEN, ti.i8)
                        else:
                            at_pixel[k] = NOWHERE
                for k in range(end):
                    if at_pixel[k] > NOWHERE:
                        at, v, u = begin + rest + k, at_pixel[k] // width, at_pixel[k] % width
                        p = _corrected(sources[at, 0], sources[at, 1], sources[at, 2], camera)
                        q = R @ p + t
                        there = _corrected(maps[j, v, u, 0], maps[j, v, u, 1], maps[j, v, u, 2], camera)
                        n = vec3(maps[j, v, u, 3], maps[j, v, u, 4], maps[j, v, u, 5])
                        m = R @ vec3(sources[at, 3], sources[at, 4], sources[at, 5])
                        if (q - there).norm() < limits[0] and m.dot(n) > limits[1]:  # a NaN normal compares false
                            to = rest + k
                            code[e, to] = ti.cast(PAIRED, ti.i8)
                            spread = sources[at, 6] ** 2 + (0.0 if ti.math.isnan(sigma[k]) else sigma[k] ** 2)
                            # depth noise acts along the line of sight: seen along the normal it shrinks by the cosine
                            out[e, to, 0] = n.dot(q - there)
                            out[e, to, 1] = ti.max(ti.abs(n.dot(there)) / there.norm() * ti.sqrt(spread), 1e-5)
                            turned = _by_axis(out, e, to, q, n, R, axis)
                            _by_camera(out, e, to, p, turned, there, n, camera)


@kernel
def sum_edges(
    code: I8_2,
    out: F32_3,  # as `pair_edges` left it
    scale: F64,  # (m,) observed over declared spread; 0 for an edge left out
    columns: I32,  # (j,) of the k derivatives, those that are asked for, ascending
    H: F64_3,  # (m, k, k) zeros, out: lower triangles
    g: F64_2,  # (m, k) zeros, out
    totals: F64_2,  # (m, 3) out: sum of squares, fitting and visible points
):
    """Normal equations of every edge with Tukey's weights."""
    for part in range(code.shape[0] * SPLIT):
        if part % SPLIT == 0:
            e = part // SPLIT
            squares, fitting, visible = ti.cast(0.0, ti.f64), 0, 0
            d, sums = ti.Vector([0.0] * COLUMNS), ti.Vector([0.0] * (COLUMNS * (COLUMNS + 1) // 2), ti.f64)
            for k in range(code.shape[1]):
                if scale[e] > 0.0 and code[e, k] > HIDDEN:
                    visible += 1
                    if code[e, k] == PAIRED:
                        residual = ti.cast(out[e, k, 0], ti.f64)
                        spread = scale[e] * out[e, k, 1]
                        inside = 1.0 - (residual / (CUT * spread)) ** 2
                        if inside > 0.0:
                            fitting += 1
                            squares += residual * residual
                            for a in range(columns.shape[0]):
                                d[a] = out[e, k, 2 + columns[a]]
                            for a in range(columns.shape[0]):
                                weighted = (inside / spread) ** 2 * d[a]
                                g[e, columns[a]] = g[e, columns[a]] + weighted * residual
                                for b in range(a + 1):
                                    sums[a * (a + 1) // 2 + b] = sums[a * (a + 1) // 2 + b] + weighted * d[b]
            totals[e, 0], totals[e, 1], totals[e, 2] = squares, fitting, visible
            for a in range(columns.shape[0]):
                for b in range(a + 1):
                    H[e, columns[a], columns[b]] = sums[a * (a + 1) // 2 + b]
