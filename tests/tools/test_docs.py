"""The pages lead where they say, show what is there, and hold today's numbers of the presets."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
PAGES = [PROJECT / "README.md", *sorted((PROJECT / "docs").rglob("*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)")


def anchors(page):
    """Headings as GitHub names them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(PROJECT)))
def test_links_lead_somewhere(page):
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if "://" not in link:
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), link


def test_a_picture_is_in_the_first_screen_and_small():
    first = (PROJECT / "README.md").read_text(encoding="utf-8").splitlines()[:12]
    shown = [link for line in first if line.startswith("![") for link in LINK.findall(line)]
    assert shown
    assert (PROJECT / shown[0]).stat().st_size < 300_000  # loads at once


def test_the_noise_over_the_distance_is_that_of_the_presets():
    command = [sys.executable, "-m", "tools.documentation.what_to_expect", "--check"]
    assert subprocess.run(command, cwd=PROJECT, check=False).returncode == 0


def test_every_tool_is_listed():
    """Each command has a row in tools/README.md, and each row a command; parts that others start have none."""
    own = {"trial.engine_side", "trial.naive", "formats.opening", "system_packages"}
    main = 'if __name__ == "__main__"'
    folder = PROJECT / "tools"
    files = [path.relative_to(folder) for path in folder.rglob("*.py") if main in path.read_text(encoding="utf-8")]
    commands = {
        ".".join(path.with_suffix("").parts) for path in files if len(path.parts) < 3 or path.parts[0] == "reproduce"
    }
    text, room, listed = (folder / "README.md").read_text(encoding="utf-8"), "", set()
    for line in text.splitlines():
        if found := re.match(r"\| `python -m tools\.([\w.]+)\.` \|", line):
            room = found[1]
        elif found := re.match(r"\| `(\w+)` \|", line):
            listed.add(f"{room}.{found[1]}")
    assert commands - own == listed
