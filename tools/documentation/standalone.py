"""A built site needs nothing but itself: no page, style or picture of it loads anything from elsewhere.

    python -m tools.documentation.standalone out/site    exit status 1, and a line for each thing that is loaded

Links that a person may follow lead anywhere; scripts, styles, fonts, frames and pictures are in the site.
"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# element: its attributes that make a browser load something by itself
LOADS = {
    "script": ("src",), "link": ("href",), "img": ("src", "srcset"), "iframe": ("src",), "source": ("src", "srcset"),
    "video": ("src", "poster"), "audio": ("src",), "object": ("data",), "embed": ("src",),
    "image": ("href", "xlink:href"), "use": ("href", "xlink:href"),
}  # fmt: skip
TOLD_ONLY = {"canonical", "next", "prev", "index", "search", "author", "copyright"}  # `rel` of links that load nothing
STYLE_LOADS = re.compile(r"""url\(\s*["']?([^"')]+)|@import\s+["']([^"']+)""")


class _Loads(HTMLParser):
    """What a browser loads by itself when it shows a page."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self._in_style = False
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attributes}
        self._in_style = tag == "style"
        self.found += loaded_by(given.get("style", ""))
        if tag == "link" and given.get("rel") in TOLD_ONLY:
            return
        for name in LOADS.get(tag, ()):
            parts = given.get(name, "").split(",") if name == "srcset" else [given.get(name, "")]
            self.found += [part.split()[0] if name == "srcset" else part for part in parts if part.strip()]

    def handle_data(self, text: str) -> None:
        if self._in_style:
            self.found += loaded_by(text)


def loaded_by(style: str) -> list[str]:
    """Addresses in a style sheet."""
    return [first or second for first, second in STYLE_LOADS.findall(style)]


def loads(file: Path) -> list[str]:
    """Addresses that a page, a drawing or a style sheet loads; those inside itself (`#...`, `data:`) left out."""
    text = file.read_text(encoding="utf-8")
    found = loaded_by(text) if file.suffix == ".css" else _Loads(text).found
    return [address for address in found if address and not address.startswith(("#", "data:"))]


def shown(site: Path) -> list[Path]:
    """Pages, drawings and style sheets; a theme's templates that lie among its styles are none."""
    files = sorted(file for file in site.rglob("*") if file.suffix in (".html", ".css", ".svg"))
    return [file for file in files if not (file.suffix == ".html" and "_static" in file.relative_to(site).parts)]


def faults(site: Path) -> list[str]:
    """One line for each address that is not in the site."""
    return [
        f"{file.relative_to(site)}: {fault}"
        for file in shown(site)
        for address in loads(file)
        if (fault := _fault(site, file, address))
    ]


def _fault(site: Path, file: Path, address: str) -> str:
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return f"loads {address}"
    path = unquote(parts.path)
    place = (site / path.lstrip("/") if path.startswith("/") else file.parent / path).resolve()
    if not place.is_relative_to(site.resolve()):
        return f"loads {address}, which lies outside"
    return "" if place.exists() else f"loads {address}, which is not there"


def main(arguments: list[str]) -> int:
    site = Path(arguments[0])
    pages = len(list(site.rglob("*.html")))
    if not pages:
        print(f"{site} holds no page")
        return 1
    told = faults(site)
    print("\n".join(told) if told else f"{pages} pages, none loads anything from elsewhere")
    return bool(told)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
