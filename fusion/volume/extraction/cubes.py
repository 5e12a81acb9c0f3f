"""The marching cubes case table, made by a rule instead of copied.

Corner o of a cell sits at (o // 4, o // 2 % 2, o % 2). A case is the sum of 2^o over the corners inside (distance
below 0). On each face the surface leaves lines between crossed edges; where all four edges are crossed, the lines
always cut off the two inside corners. The rule looks at nothing but the face, so the two cells that share it agree
and the surface has no cracks. The lines of the six faces close to loops; each loop is cut into triangles without
using a diagonal that lies in a face, which the neighbour might use too.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

CORNERS = np.array([(o // 4, o // 2 % 2, o % 2) for o in range(8)])
# edge e: axis e // 4, from the lowest corner along that axis; the pair of corners that it joins
EDGES = [(o, o | 4 >> axis) for axis in range(3) for o in range(8) if not o & 4 >> axis]
_FACES = [
    [o for o in range(8) if (o >> 2 - axis & 1) == side] for axis in range(3) for side in range(2)
]  # the four corners of each face


@cache
def table() -> NDArray[np.int8]:
    """(256, 3 * n) edge indices of each case's triangles, counter-clockwise seen from outside, -1 after the last."""
    cases = [[edge for loop in _loops(case) for triangle in _cut(loop) for edge in triangle] for case in range(256)]
    width = max(len(case) for case in cases)
    found = np.array([case + [-1] * (width - len(case)) for case in cases], np.int8)
    found.flags.writeable = False
    return found


def _loops(case: int) -> list[tuple[int, ...]]:
    """Closed loops of edges that the surface passes through."""
    after = {start: end for face in _FACES for start, end in _lines(case, face)}
    loops = []
    while after:
        start, edge = next(iter(after.items()))
        del after[start]
        loop = [start]
        while edge != start:
            loop.append(edge)
            edge = after.pop(edge)
        loops.append(tuple(loop))
    return loops


def _lines(case: int, face: list[int]) -> list[tuple[int, int]]:
    """Directed lines (edge, edge) on one face, the inside always on the same hand."""
    a, b, c, d = face
    ring = [a, b, d, c]  # around the face
    outward = CORNERS[face].mean(axis=0) - 0.5
    if np.cross(CORNERS[b] - CORNERS[a], CORNERS[c] - CORNERS[a]) @ outward < 0:
        ring.reverse()  # now counter-clockwise seen from outside of the cell
    inside = [bool(case >> corner & 1) for corner in ring]
    sides = [_edge(ring[n], ring[(n + 1) % 4]) for n in range(4)]
    # a run of inside corners is entered through one side and left through another: one line per run
    starts = [n for n in range(4) if inside[n] and not inside[n - 1]]
    lines = []
    for n in starts:
        m = n
        while inside[(m + 1) % 4]:
            m += 1
        lines.append((sides[m % 4], sides[n - 1]))
    return lines


def _edge(a: int, b: int) -> int:
    return EDGES.index((min(a, b), max(a, b)))


def _cut(loop: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Triangles of a loop, or an empty list when every way needs a diagonal within a face."""
    if len(loop) == 3:
        return [loop]
    for n in range(len(loop)):
        turned = loop[n:] + loop[:n]
        rest = turned[:1] + turned[2:]
        if not _on_one_face(turned[0], turned[2]) and (triangles := _cut(rest)):
            return [turned[:3], *triangles]  # type: ignore[list-item]
    return []


def _on_one_face(first: int, second: int) -> bool:
    corners = {*EDGES[first], *EDGES[second]}
    return any(corners <= set(face) for face in _FACES)
