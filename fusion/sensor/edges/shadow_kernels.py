# mypy: ignore-errors
"""Which pixels the projector does not reach, row by row, on Taichi."""

from fusion.compute.language import F32_2, F32_3, U8_2, kernel, ti


@kernel
def cast_shadows(t: F32_2, disparity: F32_2, from_right: ti.i32, seen: F32_3, shadow: U8_2):
    """Marks the pixels that lie behind a nearer one in the projector's row.

    Args:
        t: (h, w) column of the projector [px], from 0.
        disparity: (h, w) [px]; 0 where there is nothing.
        from_right: 1 where shadows fall to the left, so that rows are gone through from their right end.
        seen: (2, h, columns) for its own use: the nearest in each column of the projector.
        shadow: (h, w) becomes 1 where the projector does not reach, else 0.
    """
    for v in range(t.shape[0]):
        width, some = t.shape[1], 0
        reached = ti.cast(-1e30, ti.f32)
        for i in range(width):
            u = width - 1 - i if from_right else i
            shadow[v, u] = 0
            if disparity[v, u] > 0:
                # half a pixel is its own width
                if reached + 0.5 > t[v, u]:
                    shadow[v, u] = 1
                    some = 1
                reached = ti.max(reached, t[v, u])
        if some:
            for c in range(seen.shape[2]):
                seen[0, v, c] = 0.0
                seen[1, v, c] = 0.0
            for i in range(width):  # against the way, so that the first of equal columns stays, which is the nearest
                u = i if from_right else width - 1 - i
                place = ti.floor(t[v, u], ti.i32)
                seen[0, v, place] = disparity[v, u]  # a point between two columns fills both
                seen[1, v, place + 1] = disparity[v, u]
            for u in range(width):
                if shadow[v, u]:
                    place = ti.round(t[v, u], ti.i32)
                    # one pixel nearer is another surface, and not a slope
                    if ti.max(seen[0, v, place], seen[1, v, place]) <= disparity[v, u] + 1.0:
                        shadow[v, u] = 0
