"""A made-up explanation for the report's tests: walls with something hidden, explained without files."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "discrepancy"))
from made_up_walls import WALLS, looks_at, sensor_of

from fusion.discrepancy.channels.channels import channels_of
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.held_out import held_out_of
from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.naming import name_effects
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from fusion.discrepancy.unknown.unrestricted import explained, groups_of
from fusion.sensor.effect import Effect


def explanation_of(principle: str, *hidden: Effect, names: Sequence[str] = ()) -> Explanation:
    """What is found about a sensor that hides effects, with held-out frames; recordings may have names."""
    known = sensor_of(principle)
    blocks = []
    pair = (looks_at(sensor_of(principle, *hidden), seed, WALLS[:4]) for seed in (1, 2))
    for block, held in zip(*pair, strict=True):
        name = names[block.place] if names else f"wall_{block.place}"
        recording = SimpleNamespace(path=Path(name), camera=block.view.camera)
        stage = SimpleNamespace(**vars(block.stage), recording=recording)
        blocks.append(replace(block, stage=stage, held=replace(held, stage=stage)))
    before = observe(known, blocks)
    covariance = covariance_of(before)
    white = covariance.whiten(before.residual)
    groups, nothing = groups_of(before, covariance), np.zeros((len(white), 0))
    possible = explained(white, groups, nothing)
    candidates = candidates_of(before, covariance)
    named = name_effects(blocks, before, covariance, candidates)
    left = explained(named.white, groups, nothing)
    return Explanation(
        tuple(blocks), before, covariance, white, named, channels_of(named.observations, blocks), possible, left,
        tuple(candidates), held_out_of(blocks, known, before),
    )  # fmt: skip
