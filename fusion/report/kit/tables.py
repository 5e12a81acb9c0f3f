"""Small pieces of HTML: traffic lights, number tiles, tables; all text is escaped here."""

from collections.abc import Iterator, Mapping, Sequence
from html import escape

import numpy as np

from fusion.results.light import Light

WORDS = 30  # characters: a longer cell is no number, and would push the others out of the page

# shape and word tell the level too, so that colour is never the only carrier
_LAMPS = {
    "ok": ("Good", '<circle cx="8" cy="8" r="7" fill="currentColor"/>'),
    "warning": ("Look here", '<path d="M8 1 15.5 15H.5Z" fill="currentColor"/>'),
    "bad": ("Problem", '<path d="M5 1h6l4 4v6l-4 4H5l-4-4V5Z" fill="currentColor"/>'),
}


def lights(lines: Sequence[Light]) -> str:
    """A list of judged statements."""
    if not lines:
        return ""
    return '<ul class="lights">' + "".join(map(_light, lines)) + "</ul>"


def _light(light: Light) -> str:
    word, shape = _LAMPS[light.level]
    lamp = f'<span class="lamp"><svg viewBox="0 0 16 16" aria-hidden="true">{shape}</svg>{word}</span>'
    plain, name = ("", f"<b>{escape(light.subject)}</b>") if light.subject else (" plain", "")
    step = f' <span class="do">{escape(light.do)}</span>' if light.do else ""
    return f'<li class="light {light.level}{plain}">{lamp}{name}<span>{escape(light.reason)}{step}</span></li>'


def folded(title: str, inner: str) -> str:
    """Markup that a click unfolds; nothing when there is nothing inside."""
    return f"<details><summary>{escape(title)}</summary>{inner}</details>" if inner else ""


def tiles(numbers: Sequence[tuple[str, str, str, str]]) -> str:
    """Key numbers (name, value, unit, note) as a grid of tiles."""
    if not numbers:
        return ""
    cells = (
        f"<div><dt>{escape(name)}</dt><dd>{escape(value)}<small>{escape(unit)}</small></dd>"
        + (f'<dd class="note">{escape(note)}</dd>' if note else "")
        + "</div>"
        for name, value, unit, note in numbers
    )
    return '<dl class="tiles">' + "".join(cells) + "</dl>"


def settings_table(settings: Mapping[str, object]) -> str:
    """Nested settings as a table of two columns; inner names are joined by dots."""
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{escape(value)}</td></tr>' for name, value in _flat(settings)
    )
    return f'<div class="scroll"><table><tbody>{rows}</tbody></table></div>'


def numbers_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of numbers: the first column names the row, the others are right-aligned; columns of words wrap."""
    kinds = [
        ' class="words"' if any(len(row[i]) > WORDS for row in rows) else ' class="number"' for i in range(len(head))
    ]
    kinds[0] = ""
    top = "".join(f'<th scope="col"{kind}>{escape(x)}</th>' for kind, x in zip(kinds, head, strict=True))
    body = "".join(
        f'<tr><th scope="row">{escape(row[0])}</th>'
        + "".join(f"<td{kind}>{escape(cell)}</td>" for kind, cell in zip(kinds[1:], row[1:], strict=True))
        + "</tr>"
        for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _flat(settings: Mapping[str, object], before: str = "") -> Iterator[tuple[str, str]]:
    for name, value in settings.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{before}{name}.")
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
