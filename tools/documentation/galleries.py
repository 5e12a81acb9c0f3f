"""Folders of pages that are made by tools (effects, cameras) get their pictures as cards, and a place in the menu."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

GALLERIES = ("effects/README", "cameras/README")


def cards(folder: Path) -> str:
    """MyST of a grid with one card a page, in the order in which the folder's README.md links to them."""
    listed = re.findall(r"\]\(([\w-]+)\.md\)", (folder / "README.md").read_text(encoding="utf-8"))
    names = list(dict.fromkeys(listed))
    lost = {page.stem for page in folder.glob("*.md")} - {*names, "README"}
    if lost:
        raise ValueError(f"{folder / 'README.md'} has no link to {', '.join(sorted(lost))}")
    heads = {name: _head(folder / f"{name}.md") for name in names}
    titles = {n: head if list(heads.values()).count(head) == 1 else f"{head} ({n})" for n, head in heads.items()}
    lines = ["## Pictures", "", "::::{grid} 1 2 2 3", ":gutter: 3", ""]
    for name, title in titles.items():
        lines += [f":::{{grid-item-card}} {title}", f":link: {name}", ":link-type: doc", f"![]({name}.svg)", ":::", ""]
    entries = [f"{title} <{name}>" for name, title in titles.items()]
    return "\n".join([*lines, "::::", "", "```{toctree}", ":hidden:", "", *entries, "```", ""])


def _head(page: Path) -> str:
    """Its heading, without the name in code behind it."""
    first = page.read_text(encoding="utf-8").partition("\n")[0]
    return re.sub(r" ?\(`.*", "", first.removeprefix("# "))


def add(app: "Sphinx", name: str, source: list[str]) -> None:
    """Sphinx's event `source-read`."""
    if name in GALLERIES:
        source[0] += "\n" + cards((Path(app.srcdir) / name).parent)


def setup(app: "Sphinx") -> dict[str, Any]:
    app.connect("source-read", add)
    return {"parallel_read_safe": True}
