"""The page of a usual scan is small enough to send and opens at once."""

from dataclasses import replace

import numpy as np
import pytest
from browser import BINARY, Browser
from made_up import bumpy_sphere, made_up_scan

from fusion.report.scans.scan import scan_report

pytestmark = pytest.mark.slow
MOST_BYTES, MOST_SECONDS = 4e6, 2.0  # what can be sent by mail, and what a person waits for without a thought


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """A scan of 80 000 triangles with colours, coverage and all figures at full size."""
    mesh = bumpy_sphere(6)
    rng = np.random.default_rng(1)
    noise = rng.integers(-20, 20, mesh.colors.shape)  # real colours do not pack well
    mesh = replace(mesh, colors=np.clip(mesh.colors + noise, 0, 255).astype(np.uint8))
    seen = np.clip(20 + 200 * mesh.vertices[:, 0] + rng.normal(0, 2, len(mesh.vertices)), 0, None)
    path = tmp_path_factory.mktemp("usual") / "report.html"
    scan_report(path, replace(made_up_scan(72), mesh=mesh, times_seen=seen, mesh_raw=mesh))
    return path


def test_a_usual_page_is_below_4_mb(usual):
    assert usual.stat().st_size < MOST_BYTES


@pytest.mark.skipif(BINARY is None, reason="no Chromium is installed")
def test_a_usual_page_is_drawn_within_2_seconds(usual):
    """By the processor time of the page's process, which other work on the machine does not stretch; measured 0.4 s."""
    with Browser() as browser:
        begin = browser.processor_seconds()
        browser.open(usual, settle=0)
        assert browser.wait_for("document.querySelector('.viewer').dataset.drawn === 'yes'")
        assert browser.processor_seconds() - begin < MOST_SECONDS
        assert browser.evaluate("performance.getEntriesByName('viewer-drawn').length") == 1
        assert browser.console == []
