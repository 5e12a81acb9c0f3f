"""The pages as a person meets them: in a browser, without the network, without complaints."""

import io
from dataclasses import replace

import cv2
import numpy as np
import pytest
from browser import BINARY, Browser
from made_up import UP, bumpy_sphere, made_up_comparison, made_up_scan

from fusion.mesh.mesh import Mesh
from fusion.report.comparisons.comparison import Circumstances, comparison_report
from fusion.report.scans.scan import scan_report

pytestmark = [pytest.mark.slow, pytest.mark.skipif(BINARY is None, reason="no Chromium is installed")]

HOSTILE = '<script>document.title="taken"</script>" onmouseover=x $\\frac{ \u00fc\u6f22\U0001f40d</style>'


DRAWN = "document.querySelector('.viewer').dataset.drawn === 'yes'"


@pytest.fixture(scope="module", autouse=True)
def small_pictures():
    """The size of the pictures is not what is tested here, and small ones are quick."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("fusion.report.kit.views.PIXELS", 40)
        yield


@pytest.fixture(scope="module")
def scan_page(tmp_path_factory, small_pictures):
    mesh = bumpy_sphere(3)
    path = tmp_path_factory.mktemp("scan") / "report.html"
    seen = np.linspace(0, 20, len(mesh.vertices))
    scan_report(path, replace(made_up_scan(), mesh=mesh, times_seen=seen, mesh_raw=mesh))
    return path


@pytest.fixture(scope="module")
def browser():
    with Browser(1280, 900) as opened:
        yield opened


def visit(browser, path):
    """Open a page; console and requests then tell of this page only."""
    browser.console.clear()
    browser.requests.clear()
    browser.open(path)


def calm(browser):
    """Nothing was complained about, nothing was fetched beyond the page itself."""
    outside = [r for r in browser.requests if not r.startswith(("file:", "data:", "blob:"))]
    return browser.console == [] and outside == []


def drawn_colors(browser) -> int:
    """Different colours in the middle of the 3D view, coarsened so that compression or smoothing counts for nothing."""
    png = np.frombuffer(io.BytesIO(browser.screenshot(".viewer")).read(), np.uint8)
    image = cv2.imdecode(png, cv2.IMREAD_COLOR)
    h, w = image.shape[:2]
    middle = image[h // 4 : 3 * h // 4, w // 3 : 2 * w // 3] // 8
    return len(np.unique(middle.reshape(-1, 3), axis=0))


def test_scan_page_is_calm_and_its_3d_view_is_drawn(browser, scan_page):
    visit(browser, scan_page)
    assert browser.wait_for(DRAWN)
    # an empty or uniform view has 1 colour; the shaded sphere has some hundred
    assert any(drawn_colors(browser) > 20 for _ in range(20))
    assert calm(browser), (browser.console, browser.requests)
    assert browser.evaluate("document.documentElement.scrollWidth <= innerWidth")
    ids = "[...document.querySelectorAll('section, svg.plot [id]')].map(e => e.id)"
    assert browser.evaluate(f"{ids}.length - new Set({ids}).size") == 0


def test_the_3d_view_answers(browser, scan_page):
    """Layers, camera paths, keys and the way back change what is drawn; a colour scale stands with its layer."""
    visit(browser, scan_page)
    assert browser.wait_for(DRAWN)
    frame = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
    state = "document.querySelector('.viewer .bar').hidden"

    def after(action: str) -> bytes:
        browser.evaluate(f"(() => {{ const v = document.querySelector('.viewer'); {action} }})()")
        browser.evaluate(frame)
        return browser.screenshot(".viewer canvas")

    start = after("")
    assert browser.evaluate(state)
    coverage = after("v.querySelectorAll('[data-layer]')[2].click()")
    assert not browser.evaluate(state)
    paths = after("v.querySelectorAll('[data-layer]')[0].click(); v.querySelector('[data-path]').click()")
    turned = after("v.querySelector('canvas').dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowLeft'}))")
    assert len({start, coverage, turned}) == 3 and paths != turned
    assert after("v.querySelector('[data-path]').click(); v.querySelector('[data-home]').click()") == start
    assert calm(browser), browser.console


def test_without_webgl_words_stand_in_its_place(browser, tmp_path, scan_page):
    page = scan_page.read_text(encoding="utf-8").replace('getContext("webgl2"', 'getContext("nothing"')
    (tmp_path / "old.html").write_text(page, encoding="utf-8")
    visit(browser, tmp_path / "old.html")
    assert browser.wait_for("document.querySelector('.viewer.failed') !== null")
    assert "WebGL 2" in browser.evaluate("document.querySelector('.viewer').innerText")
    assert browser.console == []


def test_comparison_page_is_calm_and_its_3d_view_is_drawn(browser, tmp_path):
    about = Circumstances(up=UP, front=(0, 0, -1))
    comparison_report(tmp_path / "c.html", made_up_comparison(), bumpy_sphere(3), bumpy_sphere(2, False), about)
    visit(browser, tmp_path / "c.html")
    assert browser.wait_for(DRAWN)
    assert any(drawn_colors(browser) > 20 for _ in range(20))
    assert calm(browser), (browser.console, browser.requests)


def test_hostile_text_stays_text(browser, tmp_path):
    report = replace(
        made_up_scan(3), title=HOSTILE, subtitle=HOSTILE, rejected={1: HOSTILE}, settings={HOSTILE: {HOSTILE: HOSTILE}},
        warnings=[("bad", HOSTILE)], fingerprint=HOSTILE, command=HOSTILE, mesh=Mesh(np.zeros((0, 3))),
        mesh_raw=None, times_seen=None,
    )  # fmt: skip
    scan_report(tmp_path / "report.html", report)
    visit(browser, tmp_path / "report.html")
    assert browser.evaluate("document.title") == HOSTILE
    assert browser.evaluate("document.querySelector('h1').textContent") == HOSTILE
    assert browser.evaluate("document.querySelectorAll('[onmouseover]').length") == 0
    assert calm(browser), browser.console


def test_the_recorder_hears_what_is_wrong(browser, tmp_path):
    """The tests above mean something only if errors, warnings, exceptions and requests are heard."""
    (tmp_path / "bad.html").write_text(
        "<script>console.warn('w'); console.error('e'); setTimeout(() => nothing(), 0)</script>"
        "<img src='http://127.0.0.1:9/x.png'>"
    )
    visit(browser, tmp_path / "bad.html")
    heard = " | ".join(browser.console)
    assert "w" in browser.console and "e" in browser.console and "nothing is not defined" in heard
    assert any(r.startswith("http:") for r in browser.requests)


def test_narrow_windows_do_not_scroll_sideways(browser, scan_page):
    try:
        visit(browser, scan_page)
        for width in (820, 390):
            browser.resize(width, 800)
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
    finally:
        browser.resize(1280, 900)
