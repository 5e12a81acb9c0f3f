"""Pixels are not replicates: what a count of pixels takes for discoveries in walls that are not quite flat."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_walls import FRAMES, looks_at, sensor_of
from scipy.ndimage import gaussian_filter

from fusion.discrepancy.inference.tile_covariance import covariance_of
from fusion.discrepancy.naming.naming import name_effects
from fusion.discrepancy.naming.search.candidates import candidates_of
from fusion.discrepancy.observe.observations import observe
from tools.trial.pixelwise import pixelwise, stepwise_bic

SHARE = 0.3  # of the spread of a single frame: 9 % of its variance, the mild case of the design basis
SMOOTH_M = 0.4  # the bow of a wall
FOCAL_PX = 98.0
NULLS, ASKED = 8, 4  # nulls, and those that the engine is asked about, which takes longer


def nulls_of(principle):
    """Blocks in which nothing is missing: noise of a frame averaged, and a smooth field of each recording's own."""
    start = looks_at(sensor_of(principle), 5)
    patches = observe(sensor_of(principle), start).patches
    size = SHARE * float(np.median([np.nanmedian(patch.sigma) for patch in patches]))
    for draw in range(NULLS):
        rng = np.random.default_rng([draw, 17])
        blocks = []
        for block, patch in zip(start, patches, strict=True):
            px = SMOOTH_M * FOCAL_PX / float(np.nanmedian(patch.depth))
            # twice the spread of its kernel is how far a smoothed field is alike; a large canvas keeps its spread 1
            canvas = gaussian_filter(rng.standard_normal((400, 400)), px / np.sqrt(2), mode="wrap")
            field = size * canvas[: patch.sigma.shape[0], : patch.sigma.shape[1]] * 2 * np.sqrt(np.pi) * px / np.sqrt(2)
            noise = patch.sigma / np.sqrt(FRAMES) * rng.standard_normal(field.shape)
            about = {**vars(block.stage), "mesh_sigma_m": size, "shape": str(block.place)}
            blocks.append(replace(block, mean=patch.predicted + field + noise, stage=SimpleNamespace(**about)))
        yield blocks


@pytest.mark.slow
@pytest.mark.parametrize("principle", ["itof", "structured_light"])
def test_pixels_claim_discoveries_in_nulls_and_the_engine_does_not(principle):
    sensor, naive, claims = sensor_of(principle), 0, []
    covariance = candidates = None
    for draw, blocks in enumerate(nulls_of(principle)):
        observations = observe(sensor, blocks)
        if covariance is None:
            covariance = covariance_of(observations)
            candidates = candidates_of(observations, covariance)
        naive += bool(stepwise_bic(pixelwise(observations, candidates)))
        if draw < ASKED:
            claims += [step.effect.name for step in name_effects(blocks, observations, covariance, candidates).steps]
    # the design basis has 60 to 99 % of nulls claimed by pixels, with fewer candidates than there are here
    assert naive >= 0.6 * NULLS
    assert not claims
