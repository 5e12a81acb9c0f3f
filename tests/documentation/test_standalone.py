"""The check of the built site finds whatever a page would load from elsewhere, and lets links be."""

import pytest

from tools.documentation.standalone import faults, main

GOOD = """<html><head><link rel="stylesheet" href="_static/site.css?digest=1"><link rel="next" href="gone.html">
<style>body { background: url("data:image/png;base64,AA") }</style></head>
<body><a href="https://example.org">elsewhere</a><img src="owl.png"><svg><use href="#part"/></svg></body></html>"""

LOADED = [
    '<script src="https://cdn.example.org/x.js"></script>',
    '<link rel="stylesheet" href="//cdn.example.org/x.css">',
    '<img src="http://example.org/x.png">',
    '<img srcset="owl.png 1x, https://example.org/x.png 2x">',
    '<p style="background: url(https://example.org/x.png)">',
    "<style>@import 'https://example.org/x.css';</style>",
    '<iframe src="https://example.org"></iframe>',
    '<svg><image href="https://example.org/x.png"/></svg>',
    '<img src="../../outside.png">',
    '<img src="not_there.png">',
]


@pytest.fixture
def site(tmp_path):
    folder = tmp_path / "site"
    (folder / "_static").mkdir(parents=True)
    (folder / "_static" / "site.css").write_text("@font-face { src: url(own.woff2) }")
    (folder / "_static" / "own.woff2").write_bytes(b"")
    (folder / "owl.png").write_bytes(b"")
    (tmp_path / "outside.png").write_bytes(b"")
    (folder / "index.html").write_text(GOOD)
    return folder


def test_a_page_with_its_own_things_is_good(site, capsys):
    assert faults(site) == []
    assert main([str(site)]) == 0
    assert capsys.readouterr().out.startswith("1 pages, none")


@pytest.mark.parametrize("loaded", LOADED)
def test_what_is_loaded_from_elsewhere_is_told(site, loaded):
    (site / "page.html").write_text(f"<html><body>{loaded}</body></html>")
    (fault,) = faults(site)
    assert fault.startswith("page.html: loads ")
    assert main([str(site)]) == 1


def test_styles_are_read_too(site):
    (site / "_static" / "site.css").write_text('@import "https://example.org/fonts.css";')
    (fault,) = faults(site)
    assert fault == "_static/site.css: loads https://example.org/fonts.css"


def test_an_empty_folder_is_no_site(tmp_path, capsys):
    assert main([str(tmp_path)]) == 1
    assert "no page" in capsys.readouterr().out
