"""Tables and what a click unfolds, as markup; values as short text."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from markupsafe import Markup

from fusion.report.kit.html import part

WORDS = 30  # characters: a longer cell is no number, and would push the others out of the page


def folded(title: str, inner: str) -> Markup:
    """Markup that a click unfolds; nothing when there is nothing inside."""
    return part("folded")(title, Markup(inner))


def titled(title: str, text: str = "") -> Markup:
    """A small heading and a paragraph."""
    return part("titled")(title, text)


def paragraph(text: str) -> Markup:
    """A paragraph of plain text."""
    return Markup("<p>{}</p>").format(text)


def settings_table(settings: Mapping[str, object]) -> Markup:
    """Nested settings as a table of two columns; inner names are joined by dots."""
    return part("settings")(flat(settings))


def numbers_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Markup:
    """A table of numbers: the first column names the row, the others are right-aligned; columns of words wrap."""
    wordy = [any(len(row[i]) > WORDS for row in rows) for i in range(len(head))]
    return part("numbers")(head, rows, ["", *("words" if words else "number" for words in wordy[1:])])


def flat(settings: Mapping[str, object], before: str = "") -> Iterator[tuple[str, str]]:
    """Names and values of nested settings, as short text; inner names are joined by dots."""
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            yield from flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", shown(value)


def shown(value: object) -> str:
    """A value as short text: floats with six digits, long lists cut."""
    if value is None:
        return "not set"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{float(value):.6g}"
    if isinstance(value, np.ndarray):
        value = value.tolist() if value.size <= 16 else f"array of shape {value.shape}"
    if isinstance(value, list | tuple):
        cut = [shown(item) for item in value[:16]] + (["..."] if len(value) > 16 else [])
        return "[" + ", ".join(cut) + "]"
    text = str(value)
    return text if len(text) <= 600 else text[:600] + " ..."
