# mypy: ignore-errors
"""The nearest piece of an edge of every pixel, on Taichi.

Links are pairs of neighbouring pixels: `links[0, v + 1, u + 1]` is the number of the crossing between pixel (v, u) and
the one to its right, `links[1, ...]` that to the one below; -1 where no edge passes. So cells of 2 x 2 pixels have a
link on each side, also those that lie half outside of the image. A cell (v, u) has pixel (v, u) as its last one.
"""

from typing import NamedTuple

from fusion.compute.language import F32, F32_2, I32, I32_2, func, kernel, ti

OVERSHADOWED_PX, LARGER = 1.5, 3.0  # an edge is left out where one with a jump so many times as large is so close
BRIGHTEST = 1000.0  # the light across an edge over an own amplitude of nearly nothing stays a number
ASKEW = 0.87  # cosine of 30 deg: more than that beside an edge's normal, a pixel lies past the end of it
SLACK = 1.7  # [px] a cell with a line has pixels beside an edge, and they lie at most a diagonal apart; OpenCV adds 2 %
NONE = 1e30
I32_3 = ti.types.ndarray(ti.i32, 3)


class Rings(NamedTuple):
    """Cells by their distance from a pixel."""

    cells: I32_2  # (n, 3) the nearest first: square of the distance [px^2], and row and column from the pixel
    begins: I32  # (reach^2 + 2,) the first of them that is as far [px^2]
    margin: ti.i32  # rows and columns of `Pieces.held` beyond the cells, more than the reach [px]


class Pieces(NamedTuple):
    """Pieces of edges, as `join_crossings` fills them in."""

    held: I32_2
    lines: F32_2
    ends: I32_2


class Crossed(NamedTuple):
    """Flat indices (n, 2) of the two pixels of each crossing, and depths (n, 2) at the edge on their sides [m]."""

    pairs: I32_2
    depths: F32_2


class Own(NamedTuple):
    """Depth [m] and amplitude of all pixels (h w,)."""

    depth: F32
    amplitude: F32


class EdgeImages(NamedTuple):
    """Of all pixels (h w,), as in `Edges`."""

    distance: F32
    direction: F32
    jump: F32
    light: F32


@func
def _missing(x: ti.f32):
    return (x == x) == 0  # of NaN not even `!=` is true here


@func
def _far(x: ti.f32):
    """A depth [m] as one that compares: nothing is farther than anything."""
    return ti.select(x == x, x, NONE)


@kernel
def overshadowed(links: I32_3, pairs: I32_2, points: F32_2, jumps: F32, weak: I32):
    """Marks crossings close to one with a jump several times as large: on the brink of a surface, its own folds.

    Args:
        pairs: (n, 2) flat indices of the two pixels of each.
        points: (n, 2) of the crossings [px, u v].
        jumps: (n,) their sizes [m], infinite where one side is nothing.
        weak: (n,) becomes 1 there.
    """
    for a in range(points.shape[0]):
        row, column = pairs[a, 0] // (links.shape[2] - 2) + 1, pairs[a, 0] % (links.shape[2] - 2) + 1
        found = 0
        for v in range(ti.max(row - 2, 0), ti.min(row + 3, links.shape[1])):
            for u in range(ti.max(column - 2, 0), ti.min(column + 3, links.shape[2])):
                for way in ti.static(range(2)):
                    b = links[way, v, u]
                    if b >= 0 and jumps[a] * LARGER < jumps[b]:
                        x = ti.cast(points[a, 0], ti.f64) - points[b, 0]
                        y = ti.cast(points[a, 1], ti.f64) - points[b, 1]
                        if x * x + y * y <= OVERSHADOWED_PX * OVERSHADOWED_PX:
                            found = 1
        weak[a] = found


@kernel
def join_crossings(
    links: I32_3, pairs: I32_2, points: F32_2, weak: I32, margin: ti.i32, held: I32_2, lines: F32_2, ends: I32_2
):
    """Straight pieces of edges: two crossings of a cell are joined by a line, others each to their centre.

    Args:
        weak: (n,) 1 for crossings that are left out.
        margin: rows and columns of `held` beyond the cells, on each side.
        held: of each cell 8 i + number of lines, the first of them 4 i.
        lines: (8 n, 4) start and end of the four lines that each of two cells beside a crossing may have [px, u v u v].
        ends: (8 n, 2) the crossings at both.
    """
    for i in range(2 * points.shape[0]):
        a = i // 2
        v, u = pairs[a, 0] // (links.shape[2] - 2) + 1, pairs[a, 0] % (links.shape[2] - 2) + 1
        if i % 2:  # the cell before the link: above it, or on its left
            if links[0, v, u] == a:
                v -= 1
            else:
                u -= 1
        sides = ti.Vector([links[0, v, u], links[1, v, u], links[0, v + 1, u], links[1, v, u + 1]])
        count, x, y = 0, ti.cast(0.0, ti.f32), ti.cast(0.0, ti.f32)
        first, last = ti.cast(2**31 - 1, ti.i32), -1
        for s in ti.static(range(4)):
            if sides[s] >= 0:
                if weak[sides[s]] > 0:
                    sides[s] = -1
                else:
                    count += 1
                    x += points[sides[s], 0]
                    y += points[sides[s], 1]
                    first, last = ti.min(first, sides[s]), ti.max(last, sides[s])
        if first == a:  # else another crossing of this cell does it
            made = 0
            if count == 2:
                made = 1
                _write(lines, ends, 4 * i, first, last, points, points[last, 0], points[last, 1])
            else:
                for s in ti.static(range(4)):
                    if sides[s] >= 0:
                        _write(lines, ends, 4 * i + made, sides[s], sides[s], points, x / count, y / count)
                        made += 1
            held[v + margin, u + margin] = 8 * i + made


@func
def _write(
    lines: ti.template(), ends: ti.template(), n: ti.i32, a: ti.i32, b: ti.i32, points: ti.template(), x: ti.f32,
    y: ti.f32,
):  # fmt: skip
    lines[n, 0], lines[n, 1], lines[n, 2], lines[n, 3] = points[a, 0], points[a, 1], x, y
    ends[n, 0], ends[n, 1] = a, b


@kernel
def look_across(
    pixels: I32, off: F32, reach: ti.f32, rings: Rings, pieces: Pieces, crossed: Crossed, own: Own, out: EdgeImages
):
    """The nearest edge of some pixels, and what is on its other side; other pixels stay as they are.

    Args:
        pixels: (n,) flat indices.
        off: (n,) how far the nearest pixel beside an edge is [px].
        reach: farther edges are none [px].
    """
    lines, ends, pairs, depths = ti.static((pieces.lines, pieces.ends, crossed.pairs, crossed.depths))
    for i in range(pixels.shape[0]):
        p, width = pixels[i], pieces.held.shape[1] - 1 - 2 * rings.margin
        v, u = p // width, p % width
        least, most = ti.max(off[i] - SLACK, 0.0), ti.cast(reach * reach, ti.i32)
        line, best, share, away_u, away_v = _nearest(v, u, least, most, rings, pieces)
        if ti.sqrt(best) <= reach:
            out.distance[p], out.direction[p] = ti.sqrt(best), ti.atan2(away_v, away_u)
            at = ends[line, 0] if share < 0.5 else ends[line, 1]
            normal_u, normal_v = _towards_far(line, lines, ends, pairs, depths)
            here = own.depth[p]
            a, b = depths[at, 0], depths[at, 1]
            along = away_u * normal_u + away_v * normal_v
            on_second = (along < 0) == (_far(b) > _far(a))
            # past the end of a line its normal tells little: the depth tells
            askew = ti.abs(along) < ASKEW * ti.sqrt(best) * ti.sqrt(normal_u * normal_u + normal_v * normal_v)
            if _missing(here):
                on_second = _missing(b)
            elif _missing(a) or _missing(b) or askew:
                on_second = ti.abs(_far(b) - here) < ti.abs(_far(a) - here)
            gap = a - b if on_second else b - a
            across = pairs[at, 0] if on_second else pairs[at, 1]
            out.jump[p], out.light[p] = 0.0, 0.0
            if not (_missing(gap) or _missing(here)):
                ratio = own.amplitude[across] / own.amplitude[p]
                out.jump[p], out.light[p] = gap, ti.select(_missing(ratio), 1.0, ti.min(ratio, BRIGHTEST))


@func
def _nearest(v: ti.i32, u: ti.i32, least: ti.f32, most: ti.i32, rings: ti.template(), pieces: ti.template()):
    """The line nearest to a pixel, the square of its distance [px^2], the share of it before the nearest point, and the
    way there [px]. Of two that are as near, as at a corner, the one whose middle is nearer."""
    cells, lines = ti.static((rings.cells, pieces.lines))
    line, best, middle = -1, ti.cast(NONE, ti.f32), ti.cast(NONE, ti.f32)
    share, away_u, away_v = ti.cast(0.0, ti.f32), ti.cast(0.0, ti.f32), ti.cast(0.0, ti.f32)
    o = rings.begins[ti.cast(least * least, ti.i32)]
    while o < cells.shape[0] and cells[o, 0] <= ti.min(best, most):
        number = pieces.held[rings.margin + v + cells[o, 1], rings.margin + u + cells[o, 2]]
        for n in range(number & 7):
            l = 4 * (number >> 3) + n  # noqa: E741
            start_u, start_v = lines[l, 0], lines[l, 1]
            along_u, along_v = lines[l, 2] - start_u, lines[l, 3] - start_v
            length = ti.max(along_u * along_u + along_v * along_v, 1e-12)
            part = ((u - start_u) * along_u + (v - start_v) * along_v) / length
            part = ti.min(ti.max(part, 0.0), 1.0)
            way_u, way_v = start_u + part * along_u - u, start_v + part * along_v - v
            off = way_u * way_u + way_v * way_v
            mid_u, mid_v = (start_u + lines[l, 2]) / 2 - u, (start_v + lines[l, 3]) / 2 - v
            mid = mid_u * mid_u + mid_v * mid_v
            if off < best or (off == best and mid < middle):
                line, best, middle, share, away_u, away_v = l, off, mid, part, way_u, way_v
        o += 1
    return line, best, share, away_u, away_v


@func
def _towards_far(
    line: ti.i32, lines: ti.template(), ends: ti.template(), pairs: ti.template(), depths: ti.template()
):  # fmt: skip
    """The normal of a line, as long as the line, to the side of the farther surface."""
    normal_u, normal_v = lines[line, 1] - lines[line, 3], lines[line, 2] - lines[line, 0]
    # of the two pairs of pixels the one that the line passes between, not along
    turned = ti.Vector([_across_pair(normal_u, normal_v, pairs, ends[line, side]) for side in ti.static(range(2))])
    at, sign = ends[line, 0], turned[0]
    if ti.abs(turned[1]) > ti.abs(turned[0]):
        at, sign = ends[line, 1], turned[1]
    way = 1.0 if _far(depths[at, 1]) > _far(depths[at, 0]) else -1.0
    if ti.abs(sign) < 1e-9:  # a line without length has no normal of its own
        right = pairs[at, 1] == pairs[at, 0] + 1
        normal_u, normal_v = (way, 0.0) if right else (0.0, way)
    elif sign * way < 0:
        normal_u, normal_v = -normal_u, -normal_v
    return normal_u, normal_v


@func
def _across_pair(normal_u: ti.f32, normal_v: ti.f32, pairs: ti.template(), at: ti.i32):
    """How far a normal leads from the first to the second pixel of a crossing."""
    return normal_u if pairs[at, 1] == pairs[at, 0] + 1 else normal_v
