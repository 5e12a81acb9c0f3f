"""Parts of the site that need no Sphinx: docstrings as lists, the menu of the galleries, every name on a page."""

import re
from pathlib import Path

import pytest

import fusion
from tools.documentation.docstrings import restructured
from tools.documentation.galleries import GALLERIES, cards

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_sections_become_lists():
    lines = ["Do it.", "", "Args:", "    width, height: [px].", "    path: a folder", "        or a file.", "", ">>> 1"]
    told = restructured(lines)
    assert told[:3] == ["Do it.", "", ""]
    assert told[3:8] == [
        ":Arguments:",
        "    ``width, height``",
        "        [px].",
        "    ``path``",
        "        a folder",
    ]
    assert told[8] == "        or a file."  # as deep as the line before it: one paragraph
    assert told[-1] == ">>> 1"


def test_a_sentence_with_a_colon_is_no_entry():
    assert restructured(["Args:", "    it is so: that"]) == ["", ":Arguments:", "    it is so: that"]


@pytest.mark.parametrize("name", GALLERIES)
def test_every_page_of_a_gallery_has_its_card(name):
    folder = (DOCS / name).parent
    made = cards(folder)
    pages = {page.stem for page in folder.glob("*.md")} - {"README"}
    assert set(re.findall(r"^:link: (.+)$", made, re.M)) == pages
    entries = re.findall(r"^(.+) <(.+)>$", made, re.M)
    assert {stem for _, stem in entries} == pages
    assert len({title for title, _ in entries}) == len(pages)  # told apart in the menu


def test_a_page_without_a_link_is_told(tmp_path):
    (tmp_path / "README.md").write_text("# All\n\n[one](one.md)\n")
    for name in ("one", "two"):
        (tmp_path / f"{name}.md").write_text(f"# {name}\n")
    with pytest.raises(ValueError, match="no link to two"):
        cards(tmp_path)


def test_every_public_name_stands_on_one_page():
    rooms = [getattr(fusion, name).__module__.split(".")[1] for name in fusion.__all__ if name != "__version__"]
    pages = "\n".join(page.read_text(encoding="utf-8") for page in (DOCS / "reference").glob("*.md"))
    told = " ".join(re.findall(r"```\{names\} (.+)", pages)).split()
    assert len(told) == len(set(told))
    assert set(rooms) == set(told)
