"""The pages about the sensor effects say what the effect objects say."""

import subprocess
import sys
from pathlib import Path

import pytest

from fusion.errors import SensorError
from fusion.files.content import Content
from fusion.sensor.catalogue import IMPLEMENTED
from fusion.sensor.effects import EFFECTS
from fusion.sensor.files.entries import given_effects
from fusion.sensor.files.sensor_fields import FORMAT

PROJECT = Path(__file__).resolve().parents[2]
TOOL = [sys.executable, "-m", "tools.documentation.effects"]
LARGEST, LARGEST_FOLDER = 30_000, 1_200_000  # bytes: pages that load at once, a repository that stays small


@pytest.fixture
def pages():
    """The room of the tool, which is no part of the package."""
    from tools.documentation.effect_pages import text

    return text


def test_committed_texts_are_up_to_date():
    done = subprocess.run([*TOOL, "--check"], cwd=PROJECT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stdout}{done.stderr}"


def test_every_effect_has_a_small_picture():
    sizes = {kind.name: (PROJECT / "docs" / "effects" / f"{kind.name}.svg").stat().st_size for kind in EFFECTS}
    assert max(sizes.values()) < LARGEST and sum(sizes.values()) < LARGEST_FOLDER


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_examples_can_be_read(pages, kind):
    content = {"format": FORMAT, "effects": [pages.example(kind)]}
    (given,) = given_effects(Content(content, "sensor.json", error=SensorError))
    assert isinstance(given.effect(), IMPLEMENTED[kind.name])
    assert not given.missing()


@pytest.mark.slow
@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_every_law_shows_in_its_picture(pages, kind):
    import numpy as np

    from tools.documentation.effect_pages.pictures import PICTURES

    picture = PICTURES[kind.name]
    for panel in picture.panels:
        full, half = (np.asarray(panel.law(picture.effect(kind, panel, factor))) for factor in (1.0, 0.5))
        assert np.isfinite(full).all()
        # a law that is 0 everywhere, or does not follow its parameter, would be an empty picture
        assert np.abs(full).max() > 0 and not np.allclose(full, half, rtol=0.01, atol=0)
