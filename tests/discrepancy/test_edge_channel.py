"""Across depth edges effects are named by what they make of a step, wherever the step stands."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import FRAMES, looks_at, sensor_of, view_of
from scipy.ndimage import gaussian_filter, median_filter

from fusion.discrepancy.edges.rims import Displaced, rims_of, with_edges_at
from fusion.discrepancy.edges.steps import edge_steps, edges_next, places_of, shown_at_edges
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.frames import likeness
from fusion.discrepancy.observe.observations import observe
from fusion.sensor.effects.optics.defocus import Defocus
from fusion.sensor.effects.phase.mixed_pixels import MixedPixels
from fusion.sensor.effects.readout.lateral_noise import LateralNoise
from fusion.sensor.effects.triangulation.edge_fattening import EdgeFattening
from fusion.sensor.view import Edges

SLANT = np.deg2rad(5.0)
NEAR_M, GAP_M, WIDE_M = (0.7, 0.9, 1.2, 1.5, 1.9), 0.3, 0.3


class Taken(list):
    """Frames of a recording that was never written."""

    def __init__(self, place, frames):
        super().__init__(frames)
        self.path, self.camera = Path(f"board_{place}"), replace(view_of("itof", (1.0, 0, 0), 0).camera)


def board_view(principle, place, sides, right=0.0, wider=0.0):
    """A board before a wall with one or two upright edges, `right` px beside their place and each `wider` [m] out."""
    near = NEAR_M[place]
    view = view_of(principle, (near + GAP_M, 0, 0), place)
    v, u = np.mgrid[0 : view.camera.height, 0 : view.camera.width].astype(float)
    middle = view.camera.cx + right + np.tan(SLANT) * (v - view.camera.cy)
    half = (WIDE_M / 2 + wider) * view.camera.fx / near
    edges = [np.cos(SLANT) * (u - middle - half)]  # signed distances, positive on the wall
    if sides == 2:
        edges.append(np.cos(SLANT) * (middle - half - u))
    nearest = np.argmin(np.abs(edges), axis=0)
    signed = np.take_along_axis(np.array(edges), nearest[None], axis=0)[0]
    wall = np.max(edges, axis=0) > 0
    # on the wall the edge lies towards the board
    towards = np.where(nearest == 0, -SLANT, np.pi - SLANT) + np.where(signed > 0, np.pi, 0.0)
    reach = np.abs(signed) < 8
    known = Edges(
        np.where(reach, np.abs(signed), np.inf), np.where(reach, towards, 0.0),
        np.where(reach, np.where(signed > 0, -GAP_M, GAP_M), 0.0), np.ones(signed.shape),
    )  # fmt: skip
    depth = np.where(wall, near + GAP_M, near)
    return replace(view, depth=depth, edges=known, ir=np.full(depth.shape, 1500.0), reflectance=None)


def boards(made_with, sides=2, seed=1, moved=lambda place, rng: {}, shaken=0.0, filtered=None):
    """What a sensor gives of boards from five places; where these really are may differ from what is stated."""
    blocks = []
    for place in range(len(NEAR_M)):
        rng = np.random.default_rng([seed, place])
        where = moved(place, rng)
        frames = []
        for _ in range(FRAMES):
            off = shaken * rng.standard_normal()
            true = board_view(made_with.principle, place, sides, where.get("right", 0.0) + off, where.get("wider", 0.0))
            frames.append(made_with.sample(true.depth, true, None, rng))
        frames = np.array(frames if filtered is None else [filtered(frame) for frame in frames])
        alike = np.mean([likeness(change) for change in np.diff(frames, axis=0)], axis=0)
        stage = SimpleNamespace(
            place=place, sigma_m=0.0005, sigma_rad=0.0005, mesh_sigma_m=None, caster=None, reconstructed=False,
            shape="board", table=None, recording=Taken(place, [SimpleNamespace(depth=frame) for frame in frames]),
        )  # fmt: skip
        count = np.isfinite(frames).sum(axis=0).astype(np.int32)
        stated = board_view(made_with.principle, place, sides)
        mean, std = frames.mean(axis=0), frames.std(axis=0, ddof=1)
        blocks.append(FrameBlock(stage, tuple(range(FRAMES)), stated, mean, std, count, alike=alike))
    return blocks


def observed(principle, *hidden, known=(), **how):
    """Boards that a sensor with all effects saw, under the model that lacks the hidden ones."""
    return observe(sensor_of(principle, *known), boards(sensor_of(principle, *known, *hidden), **how))


def surveyed(place, rng):
    """A camera that stands as well as it is stated: a fifth of a pixel."""
    return {"right": 0.1 * rng.standard_normal()}


@pytest.mark.parametrize(
    ("principle", "hidden", "rivals"),
    [
        # a pixel's area and a blur of a third of a pixel make the same of an edge
        ("itof", MixedPixels(fill=1.0), {"defocus"}),
        ("itof", Defocus(width=0.7), set()),
        ("itof", LateralNoise(sigma_px=0.6), set()),
        ("structured_light", EdgeFattening(window_px=5.0), set()),
        ("structured_light", Defocus(width=0.7), set()),
    ],
)
def test_what_makes_something_else_of_an_edge_is_named(principle, hidden, rivals):
    sensor, (step,) = edge_steps(observed(principle, hidden, moved=surveyed))
    assert step.established and {step.effect.name, *step.alike} <= {hidden.name, *rivals}
    (name,) = step.std
    found = sensor.effect(hidden.name) or step.effect
    if not rivals:
        assert getattr(found, name) == pytest.approx(getattr(hidden, name), abs=4 * step.std[name])


NOTHING_MISSING = {
    "as stated": surveyed,
    "poses ten times worse": lambda place, rng: {"right": 1.5 * rng.standard_normal()},
    "the centre of the image is wrong in the file": lambda place, rng: {"right": 1.0},
    "the board is wider than its mesh": lambda place, rng: {"wider": 0.001},
}


@pytest.mark.parametrize("moved", NOTHING_MISSING.values(), ids=NOTHING_MISSING)
@pytest.mark.parametrize(
    ("principle", "known"),
    [("itof", ()), ("itof", (MixedPixels(fill=1.0), LateralNoise(sigma_px=0.4))),
     ("structured_light", (EdgeFattening(window_px=5.0),))],
)  # fmt: skip
def test_edges_that_stand_elsewhere_are_no_effect(principle, known, moved):
    for sides in (1, 2):
        assert edge_steps(observed(principle, known=known, sides=sides, moved=moved))[1] == ()


def smooth(frame):
    return gaussian_filter(frame, 0.8)


def box(frame):
    return median_filter(frame, 3)


@pytest.mark.parametrize("filtered", [smooth, box])
@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_a_filter_of_each_frame_is_no_effect_at_an_edge(principle, filtered):
    for seed in (1, 2):
        assert edge_steps(observed(principle, moved=surveyed, filtered=filtered, seed=seed))[1] == ()


@pytest.mark.parametrize(
    ("principle", "hidden"), [("itof", Defocus(width=1.6)), ("structured_light", EdgeFattening(window_px=5.0))]
)
@pytest.mark.parametrize("filtered", [smooth, box])
def test_what_a_filter_does_not_make_keeps_its_name(principle, hidden, filtered):
    (step,) = edge_steps(observed(principle, hidden, moved=surveyed, filtered=filtered))[1]
    assert step.established and hidden.name in {step.effect.name, *step.alike}


def test_one_edge_does_not_tell_how_fat_it_is_and_two_do():
    one = observed("structured_light", EdgeFattening(window_px=5.0), sides=1)
    (step,) = edge_steps(one)[1]
    assert step.effect.name == "edge_fattening" and step.std["window_px"] > 2.0
    assert "two opposite edges" in edges_next(one, replace(step, alike=("defocus",)))
    (step,) = edge_steps(observed("structured_light", EdgeFattening(window_px=5.0), sides=2))[1]
    assert step.std["window_px"] < 0.5


def test_what_light_decides_at_edges_parts_by_black_and_white():
    grey = observed("itof", MixedPixels(fill=0.8), sides=2)
    (step,) = edge_steps(grey)[1]
    step = replace(step, alike=("defocus",))
    assert "black thing before a white wall" in edges_next(grey, step)
    patches = []
    for patch in grey.patches:
        dark = replace(patch.block.view.edges, light=np.where(patch.block.view.edges.jump > 0, 8.0, 1 / 8))
        view = replace(patch.block.view, edges=dark)
        patches.append(replace(patch, block=replace(patch.block, view=view), view=replace(patch.view, edges=dark)))
    assert "from more places" in edges_next(replace(grey, patches=tuple(patches)), step)


def test_frames_that_shake_are_no_edges_that_jump():
    """All rows move together: a shaken camera; each for itself: an effect."""
    for shaken in (0.1, 0.3, 1.0):
        assert edge_steps(observed("itof", shaken=shaken))[1] == ()


def test_a_board_whose_outline_nobody_knows_tells_of_no_fat_edges():
    """The same displacement in millimetres at every distance is the board, in pixels the sensor."""
    wider = observed("structured_light", moved=lambda place, rng: {"wider": 0.004})
    assert not [step for step in edge_steps(wider)[1] if step.established]


def test_where_no_edge_is_seen_nothing_is_asked():
    seen = observe(sensor_of("itof"), looks_at(sensor_of("itof"), 1)[:3])
    assert places_of(seen) is None and edge_steps(seen) == (seen.sensor, ()) and not shown_at_edges(seen)


def test_what_would_show_here_is_not_said_to_be_invisible():
    assert {"mixed_pixels", "defocus", "lateral_noise"} <= shown_at_edges(observed("itof"))
    assert "mixed_pixels" not in shown_at_edges(observed("structured_light"))


def test_a_moved_edge_is_the_view_of_a_scene_that_is_moved():
    stated, true = (board_view("itof", 1, 2, right) for right in (0.0, 1.3))
    moved = with_edges_at(stated, Displaced(u=1.3))
    near = true.edges.distance < 5
    assert np.allclose(moved.depth, true.depth)
    for one, other in ((moved.edges.distance, true.edges.distance), (moved.edges.jump, true.edges.jump)):
        assert np.allclose(one[near], other[near], atol=1e-6)
    assert np.allclose(np.cos(moved.edges.direction - true.edges.direction)[near], 1.0)
    (rims,) = [rims_of(patch) for patch in observed("itof").patches[1:2]]
    assert set(rims.side // 2) == {0, 2}  # the wall lies to the right of one edge and to the left of the other


def test_upright_hard_edges_are_sought_wherever_softer_ones_find_them(monkeypatch):
    """All pixels beside an upright edge change sides at once: a search that creeps stands still before it."""
    monkeypatch.setitem(globals(), "SLANT", 0.0)
    hard = {"moved": lambda place, rng: {"right": 0.5 * rng.standard_normal()}}
    for seed in (0, 2):
        assert edge_steps(observed("structured_light", seed=seed, **hard))[1] == ()


def test_a_thing_that_slides_takes_its_slopes_along():
    stated, rng = board_view("itof", 1, 2), np.random.default_rng(3)
    u = np.arange(stated.camera.width)[None]
    slope = np.where(stated.depth > NEAR_M[1] + GAP_M / 2, 0.0, 0.005)  # a side that is seen nearly edge-on
    for right in 0.6 * rng.standard_normal(4):
        moved = with_edges_at(replace(stated, depth=stated.depth + slope * (u - 60)), Displaced(u=right))
        own = (slope > 0) & (stated.edges.distance > abs(right)) & (stated.edges.distance < 7)
        assert own.sum() > 200
        assert np.allclose(moved.depth[own], (stated.depth + slope * (u - 60 - right))[own])
