"""Docstrings of fusion as they are written, for autodoc: sections with names before a colon become lists.

Sphinx's own reader of such sections (napoleon) takes `width, height: [px]` for a type and a name.
"""

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

SECTIONS = {"Args:": "Arguments", "Attributes:": "Attributes", "Returns:": "Returns", "Raises:": "Raises"}
ENTRY = re.compile(r"(\*{0,2}\w[\w.]*(?:, \w[\w.]*)*): +(.+)")


def restructured(lines: list[str]) -> list[str]:
    """The docstring's lines as reStructuredText."""
    made: list[str] = []
    inside = False
    for line in lines:
        if line in SECTIONS:
            made += ["", f":{SECTIONS[line]}:"]
            inside = True
        elif inside and line and not line.startswith("    "):
            made += ["", line]
            inside = False
        elif inside and (entry := ENTRY.fullmatch(line[4:])):
            made += [f"    ``{entry[1]}``", f"        {entry[2]}"]
        else:
            made.append(line)
    return made


def process(app: "Sphinx", what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Sphinx's event `autodoc-process-docstring`."""
    lines[:] = [*restructured(lines), ""]


def setup(app: "Sphinx") -> dict[str, Any]:
    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True}
