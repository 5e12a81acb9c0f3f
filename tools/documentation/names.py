"""The directive `names`: the public names of some rooms of fusion, from their docstrings.

The build fails where a public name stands on no page: nobody has to remember to list a new one.
"""

import importlib
import inspect
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective

FUSION = importlib.import_module("fusion")
NAMES = {name: getattr(FUSION, name) for name in sorted(FUSION.__all__) if name != "__version__"}
TOLD = "public_names"  # attribute of Sphinx's environment: names by document


def names_of(rooms: list[str]) -> list[str]:
    """Public names whose room is one of these, by the alphabet."""
    return [name for name, thing in NAMES.items() if thing.__module__.split(".")[1] in rooms]


class Names(SphinxDirective):
    """Functions, then the types that they take and return."""

    required_arguments, final_argument_whitespace = 1, True

    def run(self) -> list[nodes.Node]:
        names = names_of(self.arguments[0].split())
        env: Any = self.env
        setattr(env, TOLD, getattr(env, TOLD, {}) | {env.docname: names})
        made = nodes.section()
        for title, kind in (("Functions", "function"), ("Types", "class")):
            chosen = [name for name in names if inspect.isclass(NAMES[name]) == (kind == "class")]
            section = nodes.section("", nodes.title("", title), ids=[title.lower()])
            for name in chosen:
                members = ["   :members:"] * (kind == "class")
                lines = ["```{eval-rst}", f".. auto{kind}:: fusion.{name}", *members, "```"]
                self.state.nested_parse(StringList(lines, source=name), 0, section)
            made += [section] * bool(chosen)
        return made.children


def all_told(app: Sphinx, env: Any) -> None:
    """Raises ExtensionError where a public name stands on no page."""
    told = {name for names in getattr(env, TOLD, {}).values() for name in names}
    if lost := set(NAMES) - told:
        raise ExtensionError(f"public names on no page of docs/reference: {', '.join(sorted(lost))}")


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("names", Names)
    app.connect("env-check-consistency", all_told)
    return {"parallel_read_safe": False}
