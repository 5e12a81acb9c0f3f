"""The kernels of edges and shadows against the same written out plainly."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera
from fusion.sensor.edges.nearest import Crossings, nearest_edges
from fusion.sensor.effects.light.projector_shadow import shadowed
from fusion.sensor.view import View

LENS = Camera(64, 48, 52.5, 52.0, 31.5, 23.5, (0.08, -0.1, 0.001, 0.002))


def boxes(rng, shape) -> np.ndarray:
    """Boxes before a wall, with holes."""
    depth = np.full(shape, 2.5, np.float32)
    for _ in range(6):
        v, u = rng.integers(0, shape[0]), rng.integers(0, shape[1])
        depth[v : v + rng.integers(2, 15), u : u + rng.integers(2, 15)] = rng.choice([rng.uniform(0.6, 2.4), np.nan])
    return depth


def crossings_of(depth, rng) -> Crossings:
    """Wherever neighbours differ, at random places between them."""
    at = np.arange(depth.size).reshape(depth.shape)
    first = np.concatenate([at[:, :-1].ravel(), at[:-1].ravel()])
    second = np.concatenate([at[:, 1:].ravel(), at[1:].ravel()])
    z = depth.reshape(-1)
    apart = ~((z[first] == z[second]) | (np.isnan(z[first]) & np.isnan(z[second])))
    first, second = first[apart], second[apart]
    depths = np.column_stack([z[first], z[second]])
    return Crossings(first, second, rng.uniform(0.05, 0.95, len(first)).astype(np.float32), depths)


def lines_of(crossings, width) -> list[tuple[np.ndarray, np.ndarray]]:
    """Start and end of every line: cell by cell, the crossings on its sides joined, or each joined to their middle."""
    on_cells: dict[tuple[int, int], list[np.ndarray]] = {}
    for first, second, place in zip(crossings.first, crossings.second, crossings.position, strict=True):
        v, u = divmod(int(first), width)
        across = second == first + 1
        point = np.array([u + place, v]) if across else np.array([u, v + place])
        for cell in ((v - 1, u), (v, u)) if across else ((v, u - 1), (v, u)):
            on_cells.setdefault(cell, []).append(point)
    lines = []
    for points in on_cells.values():
        middle = np.mean(points, axis=0)
        lines += [tuple(points)] if len(points) == 2 else [(point, middle) for point in points]
    return lines


@pytest.mark.parametrize("shape", [(24, 30), (5, 40), (1, 20), (20, 1), (2, 2)])
@pytest.mark.parametrize("reach", [1.0, 2.5, 8.0])
def test_the_nearest_line_is_found_and_its_other_side(shape, reach):
    rng = np.random.default_rng(3)
    for _ in range(4):
        # of one jump: none overshadows another
        depth = np.where(np.isnan(boxes(rng, shape)), np.float32(1.0), np.float32(1.5))
        crossings = crossings_of(depth, rng)
        edges = nearest_edges(crossings, depth, 1 / depth**2, reach)
        lines = lines_of(crossings, shape[1])
        expected = np.full(shape, np.inf)
        for v, u in np.ndindex(shape):
            for start, end in lines:
                along, pixel = end - start, np.array([u, v])
                share = np.clip((pixel - start) @ along / max(along @ along, 1e-12), 0, 1)
                expected[v, u] = min(expected[v, u], np.linalg.norm(start + share * along - pixel))
        sure = np.abs(expected - reach) > 0.75  # beyond: pixels beside an edge may be out of reach, and their edge not
        expected[expected > reach] = np.inf
        assert np.allclose(edges.distance[sure], expected[sure], atol=1e-5)
        beside = edges.distance < 0.5
        jump = np.where(depth == 1.0, 0.5, -0.5)
        assert np.allclose(edges.jump[beside], jump[beside])
        assert np.allclose(edges.light[beside], np.where(depth == 1.0, 1 / 2.25, 2.25)[beside], rtol=1e-5)


def test_an_edge_at_the_foot_of_a_larger_one_is_left_out():
    depth = np.full((9, 12), 1.0, np.float32)
    depth[:, 5] = 1.01  # a fold on the brink
    depth[:, 6:] = 2.0
    crossings = crossings_of(depth, np.random.default_rng(0))
    edges = nearest_edges(crossings, depth, np.ones_like(depth))
    assert (edges.jump[:, 4] > 0.5).all() and (np.abs(edges.jump[:, 5]) > 0.5).all()


def test_no_other_side_is_told_of_nothing():
    depth = np.full((9, 12), 1.0, np.float32)
    depth[:, 6:] = np.nan
    edges = nearest_edges(crossings_of(depth, np.random.default_rng(0)), depth, np.ones_like(depth))
    near = np.isfinite(edges.distance)
    assert near.any() and (edges.jump[near] == 0).all() and (edges.light[near] == 0).all()


@pytest.mark.parametrize("camera", [LENS, Camera(64, 48, 52.5, 52.5, 31.5, 23.5)], ids=["lens", "pinhole"])
@pytest.mark.parametrize("baseline", [0.3, -0.3])
def test_a_shadow_is_where_something_nearer_has_the_same_column_of_the_projector(camera, baseline):
    rng = np.random.default_rng(5)
    depth = boxes(rng, camera.shape)
    found = shadowed(depth, baseline, View(camera, depth))
    disparity = np.nan_to_num(camera.fx * abs(baseline) / depth)
    column = camera.rays()[..., 0] * camera.fx * (1 if baseline < 0 else -1)
    t = column + disparity
    # at most a pixel wide, points fill what is between them; one pixel nearer is another surface
    hidden = (np.abs(t[:, :, None] - t[:, None, :]) < 0.5) & (disparity[:, None, :] > disparity[:, :, None] + 1.5)
    far = (np.abs(t[:, :, None] - t[:, None, :]) < 1.6) & (disparity[:, None, :] > disparity[:, :, None] + 0.9)
    seen = disparity > 0
    assert found.any() and not found[~seen].any()
    assert (found | ~hidden.any(axis=2) | ~seen).mean() > 0.995  # two that fall into one column: one of them is kept
    assert not (found & ~far.any(axis=2)).any()
