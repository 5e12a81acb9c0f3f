"""Markup by Jinja2: templates stand beside the code that fills them, and what is not markup already is escaped."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

PACKAGE = Path(__file__).parents[2]


@cache
def _environment() -> Environment:
    loader, missing = FileSystemLoader(PACKAGE), StrictUndefined
    return Environment(loader=loader, autoescape=True, undefined=missing, trim_blocks=True, lstrip_blocks=True)


def markup(template: str, **values: Any) -> Markup:
    """A template of the package, by its path in it, filled with values."""
    return Markup(_environment().get_template(template).render(values))


def part(name: str) -> Callable[..., Markup]:
    """A macro of parts.html, as a function.

    >>> part("titled")("a < b")
    Markup('<h3>a &lt; b</h3>')
    """
    macro: Callable[..., Markup] = getattr(_environment().get_template("report/kit/parts.html").module, name)
    return macro
