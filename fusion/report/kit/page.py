"""One self-contained HTML page made of parts: every text is escaped, nothing is loaded from outside."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from string import Template

from fusion.files.output.publish import atomic_file
from fusion.progress import timeless
from fusion.report.kit.tables import folded, lights, settings_table, tiles
from fusion.report.kit.versions import versions
from fusion.results.light import Light, worst_first


@dataclass(frozen=True)
class Number:
    """A key number: what it is, its value as text, its unit and a note below it ("" when it has none)."""

    name: str
    value: str
    unit: str = ""
    note: str = ""


@dataclass(frozen=True)
class Figure:
    """A picture that is ready for the page."""

    title: str  # the finding, one line
    svg: str  # inline SVG, made by fusion.report.kit.palette.to_svg
    alt: str  # what a person who cannot see it should know
    caption: str = ""  # how to read it


@dataclass(frozen=True)
class Section:
    """A titled part of the page: a leading sentence, then figures; `html` is trusted, ready-made markup.

    `folded` figures are for who wants to know more: a click unfolds them.
    """

    title: str
    lead: str = ""
    figures: tuple[Figure, ...] = ()
    html: str = ""
    screen_only: bool = False
    folded: tuple[Figure, ...] = ()


@dataclass(frozen=True)
class Page:
    """All that stands on a page; parts that are empty are left out."""

    # title, subtitle: plain text
    title: str
    subtitle: str = ""
    verdict: str = ""  # one word, and what made it so; "" where there is none
    summary: Sequence[Light] = ()  # about five judged lines; shown with the worst first
    numbers: Sequence[Number] = ()  # key numbers with units
    sections: Sequence[Section] = ()  # in the order of reading
    # further lights, for instance from reading the input; "ok" ones are notes, which are folded
    warnings: Sequence[Light] = ()
    settings: Mapping[str, object] | None = None  # nested settings, shown as a table
    fingerprint: Mapping[str, object] | None = None  # what identifies the input, name to value
    command: str = ""  # the command line that made the page
    script: str = ""  # trusted JavaScript put once at the head of the page
    dated: bool = True  # says when it was made


OPEN_WARNINGS = 8  # more would push the result itself off the first screen

# the page may use only what stands in it: no network, no plug-ins, no forms
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:; connect-src 'none'; "
    "form-action 'none'; base-uri 'none'; "
)
TEMPLATE = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))


def write_page(path: Path, page: Page) -> None:
    """Write the page as one HTML file, whole or not at all."""
    text = render(page)
    with atomic_file(Path(path)) as partial:
        # a hostile file name may hold lone surrogates, which UTF-8 cannot write
        partial.write_text(text, encoding="utf-8", errors="replace")


def render(page: Page) -> str:
    """The page as HTML text."""
    sections = [_summary(page), _warnings(page), *map(_section, page.sections), _provenance(page)]
    present = [(title, html) for title, html in sections if html]
    names = [anchor(title, place) for place, (title, _) in enumerate(present)]
    links = "".join(f'<a href="#{name}">{escape(title)}</a>' for name, (title, _) in zip(names, present, strict=True))
    body = "\n".join(
        html.replace("<section", f'<section id="{name}"', 1) for name, (_, html) in zip(names, present, strict=True)
    )
    return TEMPLATE.substitute(
        title=escape(page.title),
        subtitle=escape(page.subtitle),
        style=Path(__file__).with_name("page.css").read_text(encoding="utf-8"),
        script=f"<script>{page.script}</script>" if page.script else "",
        policy=POLICY + ("script-src 'unsafe-inline'" if page.script else "script-src 'none'"),
        navigation=f'<nav aria-label="Sections">{links}</nav>' if len(present) > 2 else "",
        body=body,
        version=escape(versions()["fusion"]),
        date="" if timeless() or not page.dated else datetime.now(UTC).strftime(" on %Y-%m-%d %H:%M UTC"),
    )


def anchor(title: str, place: int) -> str:
    """A name for links, unique by its place on the page."""
    return f"s{place}-" + (re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:40] or "part")


def _summary(page: Page) -> tuple[str, str]:
    """The lights, the worst first, and the key numbers; the notes too where no warning follows."""
    word, _, why = page.verdict.partition(":")
    inner = f'<p class="verdict {escape(word)}"><b>Verdict: {escape(word)}</b>{escape(why)}</p>' if word else ""
    inner += lights(worst_first(page.summary))
    inner += tiles([(x.name, x.value, x.unit, x.note) for x in page.numbers])
    inner += "" if _told(page) else _notes(page)
    return "Summary", f"<section><h2>Summary</h2>{inner}</section>" if inner else ""


def _section(section: Section) -> tuple[str, str]:
    if not (section.figures or section.folded or section.html):
        return section.title, ""
    lead = f'<p class="lead">{escape(section.lead)}</p>' if section.lead else ""
    figures = "".join(map(_figure, section.figures))
    figures += "".join(folded(figure.title, _figure(figure)) for figure in section.folded)
    kind = ' class="screen"' if section.screen_only else ""
    return section.title, f"<section{kind}><h2>{escape(section.title)}</h2>{lead}{figures}{section.html}</section>"


def _figure(figure: Figure) -> str:
    caption = f"<figcaption>{escape(figure.caption)}</figcaption>" if figure.caption else ""
    label = f'class="plot" role="img" aria-label="{escape(figure.alt, quote=True)}"'
    svg = figure.svg.replace("<svg", f"<svg {label}", 1)
    return f'<figure><h3>{escape(figure.title)}</h3><div class="plots">{svg}</div>{caption}</figure>'


def _warnings(page: Page) -> tuple[str, str]:
    """Each warning once, the worst first; those beyond the first few are folded, and the notes."""
    told = _told(page)
    inner = lights(told[:OPEN_WARNINGS])
    inner += folded(f"{len(told) - OPEN_WARNINGS} more warnings", lights(told[OPEN_WARNINGS:]))
    return "Warnings", f"<section><h2>Warnings</h2>{inner}{_notes(page)}</section>" if told else ""


def _told(page: Page) -> list[Light]:
    return [light for light in worst_first(page.warnings) if light.level != "ok"]


def _notes(page: Page) -> str:
    """What is only good to know."""
    notes = [light for light in worst_first(page.warnings) if light.level == "ok"]
    return folded("1 note" if len(notes) == 1 else f"{len(notes)} notes", lights(notes))


def _provenance(page: Page) -> tuple[str, str]:
    """How the page came about: command, input, settings, versions."""
    inner = ""
    if page.command:
        inner += f"<h3>Command</h3><pre>{escape(page.command)}</pre>"
    if page.fingerprint:
        inner += "<h3>Input</h3>" + settings_table(page.fingerprint)
    if page.settings:
        inner += folded("Settings", settings_table(page.settings))
    inner += folded("Versions", settings_table(versions()))
    return "How it was made", f"<section><h2>How it was made</h2>{inner}</section>"
