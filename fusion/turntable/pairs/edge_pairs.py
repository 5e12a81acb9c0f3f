# mypy: ignore-errors
"""All edges of a joint fit on Taichi: pairs, residuals and derivatives, errors of the camera included; their sums."""

from fusion.compute.language import func, kernel, ti
from fusion.compute.shares import SPLIT
from fusion.geometry.lanes import project
from fusion.tracking.pairs import CUT
from fusion.turntable.selfcheck import DEPTH

vec3 = ti.types.vector(3, ti.f32)
ERRORS = len(DEPTH)
terms_type = ti.types.vector(ERRORS, ti.f32)
HIDDEN, SEEN, PAIRED = 0, 1, 2  # the model's camera cannot tell; sees the place, and no partner there; a pair


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
def _corrected(p: ti.template(), check: ti.template(), span: ti.template(), old: ti.template(), camera: ti.template()):
    """A point with the errors of camera and depth taken out."""
    z = p[2]
    if span[3] > 0.0:
        terms = depth_terms(p, span)
        for k in ti.static(range(ERRORS)):
            z += terms[k] * check[3 + k]
    x = (p[0] / p[2] * old[0] - check[1]) / camera[0] * z
    y = (p[1] / p[2] * old[1] - check[2]) / camera[1] * z
    return vec3(x, y, z)


@func
def _along(p: ti.template(), d: ti.template(), camera: ti.template()):
    """Change (3,) of a point along a direction per unit of focal length and principal point."""
    return vec3(-(d[0] * p[0] + d[1] * p[1]), -d[0] * p[2] / camera[0], -d[1] * p[2] / camera[1])


@kernel
def pair_edges(
    edges: ti.types.ndarray(dtype=ti.i32, ndim=2),  # (m, 2) source and model view
    poses: ti.types.ndarray(dtype=ti.f32, ndim=3),  # (m, 4, 4) the turn from source to model
    first: ti.types.ndarray(dtype=ti.i32, ndim=1),  # (n + 1,) where the points of each view start
    sources: ti.types.ndarray(dtype=ti.f32, ndim=2),  # (all, 7) point, normal, sigma
    maps: ti.types.ndarray(dtype=ti.f32, ndim=4),  # (n, h, w, 7) the same of every view's pixels
    lens: ti.types.ndarray(dtype=ti.f32, ndim=1),  # (12,) the corrected camera, see `association`
    stated: ti.types.ndarray(dtype=ti.f32, ndim=1),  # (2,) fx, fy as stated
    check: ti.types.ndarray(dtype=ti.f32, ndim=1),  # (13,) errors of camera and depth
    span: ti.types.ndarray(dtype=ti.f32, ndim=1),  # (4,) near, far [m], 1 for triangulation, 0 without depth errors
    axis: ti.types.ndarray(dtype=ti.f32, ndim=2),  # (4, 3) point, direction, the two across
    limits: ti.types.ndarray(dtype=ti.f32, ndim=1),  # (3,) reach [m], least cosine, pixels between those of `maps`
    pixel: ti.types.ndarray(dtype=ti.i32, ndim=2),  # (m, most) to work with
    code: ti.types.ndarray(dtype=ti.i8, ndim=2),  # (m, most) out
    out: ti.types.ndarray(dtype=ti.f32, ndim=3),  # (m, most, 7 to 20) out, of pairs: residual, sigma, derivatives
):
    for part in range(edges.shape[0] * SPLIT):
        if part % SPLIT == 0:
            e = part // SPLIT
            i, j = edges[e, 0], edges[e, 1]
            R = ti.Matrix([[poses[e, r, c] for c in ti.static(range(3))] for r in ti.static(range(3))])
            t = vec3(poses[e, 0, 3], poses[e, 1, 3], poses[e, 2, 3])
            width = maps.shape[2]
            # pixels first: so short a loop has several of them under way, and memory answers while it goes on
            for k in range(code.shape[1]):
                at = first[i] + k
                code[e, k] = ti.cast(HIDDEN, ti.i8)
                if at < first[i + 1]:
                    p = _corrected(vec3(sources[at, 0], sources[at, 1], sources[at, 2]), check, span, stated, lens)
                    q = R @ p + t
                    x, y = project(q[0] / q[2], q[1] / q[2], lens, True)
                    u = ti.floor(x / limits[2] + 0.5, ti.i32)
                    v = ti.floor(y / limits[2] + 0.5, ti.i32)
                    if q[2] > 0.05 and 0 <= u < width and 0 <= v < maps.shape[1] and maps[j, v, u, 2] > 0.0:
                        code[e, k] = ti.cast(SEEN, ti.i8)
                        pixel[e, k] = v * width + u
            for k in range(code.shape[1]):
                if code[e, k] == SEEN:
                    at, v, u = first[i] + k, pixel[e, k] // width, pixel[e, k] % width
                    p = _corrected(vec3(sources[at, 0], sources[at, 1], sources[at, 2]), check, span, stated, lens)
                    q = R @ p + t
                    there = _corrected(
                        vec3(maps[j, v, u, 0], maps[j, v, u, 1], maps[j, v, u, 2]), check, span, stated, lens
                    )
                    n = vec3(maps[j, v, u, 3], maps[j, v, u, 4], maps[j, v, u, 5])
                    m = R @ vec3(sources[at, 3], sources[at, 4], sources[at, 5])
                    if (q - there).norm() < limits[0] and m.dot(n) > limits[1]:  # a NaN normal compares false
                        code[e, k] = ti.cast(PAIRED, ti.i8)
                        wide = ti.math.isnan(maps[j, v, u, 6])
                        spread = sources[at, 6] ** 2 + (0.0 if wide else maps[j, v, u, 6] ** 2)
                        # depth noise acts along the line of sight: seen along the normal it shrinks by the cosine
                        out[e, k, 0] = n.dot(q - there)
                        out[e, k, 1] = ti.max(ti.abs(n.dot(there)) / there.norm() * ti.sqrt(spread), 1e-5)
                        arm = q - vec3(axis[0, 0], axis[0, 1], axis[0, 2])
                        before, turned = R.transpose() @ arm, R.transpose() @ n  # arm and normal before the turn
                        out[e, k, 2] = n.dot(vec3(axis[1, 0], axis[1, 1], axis[1, 2]).cross(arm))
                        for s in ti.static(range(2)):
                            across = vec3(axis[2 + s, 0], axis[2 + s, 1], axis[2 + s, 2])
                            out[e, k, 3 + s] = n.dot(across.cross(arm)) - turned.dot(across.cross(before))
                            out[e, k, 5 + s] = (n - turned).dot(across)
                        lenses = _along(p, turned, lens) - _along(there, n, lens)
                        for s in ti.static(range(3)):
                            if out.shape[2] > 7 + s:
                                out[e, k, 7 + s] = lenses[s]
                        if out.shape[2] > 10:
                            change = turned.dot(p) / p[2] * depth_terms(p, span)
                            change -= n.dot(there) / there[2] * depth_terms(there, span)
                            for s in ti.static(range(ERRORS)):
                                if out.shape[2] > 10 + s:
                                    out[e, k, 10 + s] = change[s]


@kernel
def sum_edges(
    code: ti.types.ndarray(dtype=ti.i8, ndim=2),
    out: ti.types.ndarray(dtype=ti.f32, ndim=3),  # as `pair_edges` left it
    scale: ti.types.ndarray(dtype=ti.f64, ndim=1),  # (m,) observed over declared spread; 0 for an edge left out
    columns: ti.types.ndarray(dtype=ti.i32, ndim=1),  # (j,) of the k derivatives, those that are asked for, ascending
    H: ti.types.ndarray(dtype=ti.f64, ndim=3),  # (m, k, k) zeros, out: lower triangles
    g: ti.types.ndarray(dtype=ti.f64, ndim=2),  # (m, k) zeros, out
    totals: ti.types.ndarray(dtype=ti.f64, ndim=2),  # (m, 3) out: sum of squares, fitting and visible points
):
    """Normal equations of every edge with Tukey's weights."""
    for part in range(code.shape[0] * SPLIT):
        if part % SPLIT == 0:
            e = part // SPLIT
            squares, fitting, visible = ti.cast(0.0, ti.f64), 0, 0
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
                                i = columns[a]
                                weighted = (inside / spread) ** 2 * out[e, k, 2 + i]
                                g[e, i] = g[e, i] + weighted * residual
                                for b in range(a + 1):
                                    j = columns[b]
                                    H[e, i, j] = H[e, i, j] + weighted * out[e, k, 2 + j]
            totals[e, 0], totals[e, 1], totals[e, 2] = squares, fitting, visible
