"""Writes docs/effects/ from the sensor effects themselves.

python -m tools.documentation.effects            all pages and pictures
python -m tools.documentation.effects --text     without the pictures
python -m tools.documentation.effects --check    writes nothing; tells which texts are out of date, exit status 1
"""

import argparse
import sys
from pathlib import Path

from fusion.files.output.publish import atomic_file
from fusion.sensor.effects import EFFECTS
from tools.documentation.effect_pages import text

PROJECT = Path(__file__).resolve().parents[2]
PAGES = Path("docs/effects")


def texts() -> dict[Path, str]:
    """Every text that is made, by its path in the project."""
    pages = {PAGES / f"{kind.name}.md": text.page(kind) for kind in EFFECTS}
    return {**pages, PAGES / "README.md": text.index()}


def out_of_date(made: dict[Path, str]) -> list[str]:
    """What differs from the files of the project, one line each."""
    found = []
    for path, content in made.items():
        file = PROJECT / path
        if not file.exists() or file.read_text(encoding="utf-8") != content:
            found.append(f"{path} is {'out of date' if file.exists() else 'missing'}")
    expected = {path.name for path in made if path.parent == PAGES} | {f"{kind.name}.svg" for kind in EFFECTS}
    there = {path.name for path in (PROJECT / PAGES).glob("*")}
    found += [f"{PAGES / name} belongs to no effect" for name in sorted(there - expected)]
    return found + [f"{PAGES / name} is missing" for name in sorted(expected - there) if name.endswith(".svg")]


def draw() -> None:
    """All pictures."""
    from tools.documentation.effect_pages.drawing import svg
    from tools.documentation.effect_pages.pictures import PICTURES

    for kind in EFFECTS:
        with atomic_file(PROJECT / PAGES / f"{kind.name}.svg") as partial:
            partial.write_bytes(svg(kind, PICTURES[kind.name]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--text", action="store_true", help="leave the pictures as they are")
    parser.add_argument("--check", action="store_true", help="write nothing, tell what is out of date")
    options = parser.parse_args()
    made = texts()
    if options.check:
        found = out_of_date(made)
        print("\n".join([*found, f"run: {text.COMMAND}"] if found else ["up to date"]))
        return bool(found)
    (PROJECT / PAGES).mkdir(parents=True, exist_ok=True)
    for path, content in made.items():
        with atomic_file(PROJECT / path) as partial:
            partial.write_text(content, encoding="utf-8")
    if not options.text:
        draw()
    print(f"{len(EFFECTS)} effects in {PAGES}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
