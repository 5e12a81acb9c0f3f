"""The directive `commands`: every command of the console program, from the parser that reads its options."""

import argparse
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from fusion.commands.catalogue import COMMANDS, load
from fusion.commands.main import parser_of


class Commands(SphinxDirective):
    """One section a command, and inside it one a part (`fusion calibrate depth`)."""

    def run(self) -> list[nodes.Node]:
        parsers = [parser_of(name, load(name)) for name in COMMANDS]
        return [section(parser) for parser in parsers]


def section(parser: argparse.ArgumentParser) -> nodes.section:
    """What `--help` says of a command, as a section of a page."""
    made = nodes.section(ids=[parser.prog.replace(" ", "-")])
    made += nodes.title("", "", nodes.literal("", parser.prog))
    made += _text(parser.description or "")
    usage = " ".join(parser.format_usage().removeprefix("usage: ").split())  # the page breaks its lines
    made += nodes.literal_block(usage, usage, language="text", classes=["usage"])
    inner = []
    for group in parser._action_groups:
        shown = [action for action in group._group_actions if not isinstance(action, argparse._SubParsersAction)]
        inner += [action for action in group._group_actions if isinstance(action, argparse._SubParsersAction)]
        if shown:
            made += nodes.rubric("", (group.title or "").capitalize())
            made += nodes.definition_list("", *(_item(parser, action) for action in shown), classes=["options"])
    if parser.epilog:
        made += nodes.literal_block(parser.epilog, parser.epilog, language="text")
    for parts in inner:
        for part in dict.fromkeys(parts.choices.values()):
            made += section(part)
    return made


def _item(parser: argparse.ArgumentParser, action: argparse.Action) -> nodes.definition_list_item:
    formatter = parser._get_formatter()
    term = nodes.term("", "", nodes.literal("", formatter._format_action_invocation(action)))
    told = "" if action.help in (None, argparse.SUPPRESS) else formatter._expand_help(action)
    return nodes.definition_list_item("", term, nodes.definition("", _text(told)))


def _text(words: str) -> nodes.paragraph:
    """A paragraph; what stands between backticks is code."""
    made = nodes.paragraph()
    for i, part in enumerate(words.split("`")):
        made += nodes.literal("", part) if i % 2 else nodes.Text(part)
    return made


def setup(app: Sphinx) -> dict[str, Any]:
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True}
