"""One self-contained HTML page made of parts: every text is escaped, nothing is loaded from outside."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from markupsafe import Markup

from fusion.files.output.publish import atomic_file
from fusion.progress import timeless
from fusion.report.kit.html import markup
from fusion.report.kit.tables import flat
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

    @property
    def labelled(self) -> Markup:
        """The picture with its words for those who cannot see it."""
        label = Markup('<svg class="plot" role="img" aria-label="{}"').format(self.alt)
        return Markup(self.svg.replace("<svg", label, 1))


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

    @property
    def judged(self) -> tuple[str, str]:
        """The verdict's word, and what made it so."""
        word, _, why = self.verdict.partition(":")
        return word, why

    @property
    def lights(self) -> tuple[Light, ...]:
        """The judged lines, the worst first."""
        return worst_first(self.summary)

    @property
    def told(self) -> list[Light]:
        """Each warning once, the worst first."""
        return [light for light in worst_first(self.warnings) if light.level != "ok"]

    @property
    def notes(self) -> list[Light]:
        """What is only good to know."""
        return [light for light in worst_first(self.warnings) if light.level == "ok"]


@dataclass(frozen=True)
class _Placed:
    """A part of the page that has something to show; without a section it is one that every page may have."""

    title: str
    anchor: str
    section: Section | None = None

    @property
    def screen_only(self) -> bool:
        return self.section is not None and self.section.screen_only


OPEN_WARNINGS = 8  # more would push the result itself off the first screen

# the page may use only what stands in it: no network, no plug-ins, no forms
POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; worker-src blob:; connect-src 'none'; "
    "form-action 'none'; base-uri 'none'; "
)


def write_page(path: Path, page: Page) -> None:
    """Write the page as one HTML file, whole or not at all."""
    text = render(page)
    with atomic_file(Path(path)) as partial:
        # a hostile file name may hold lone surrogates, which UTF-8 cannot write
        partial.write_text(text, encoding="utf-8", errors="replace")


def render(page: Page) -> str:
    """The page as HTML text."""
    return markup(
        "report/kit/page.html",
        page=page,
        sections=_placed(page),
        style=Markup(Path(__file__).with_name("page.css").read_text(encoding="utf-8")),
        policy=Markup(POLICY + ("script-src 'unsafe-inline'" if page.script else "script-src 'none'")),
        open=OPEN_WARNINGS,
        flat=flat,
        versions=versions(),
        date="" if timeless() or not page.dated else datetime.now(UTC).strftime(" on %Y-%m-%d %H:%M UTC"),
    )


def _placed(page: Page) -> list[_Placed]:
    summary = bool(page.verdict or page.summary or page.numbers or (page.notes and not page.told))
    parts: list[tuple[str, Section | None]] = [("Summary", None)] if summary else []
    parts += [("Warnings", None)] if page.told else []
    parts += [(one.title, one) for one in page.sections if one.figures or one.folded or one.html]
    parts += [("How it was made", None)]
    return [_Placed(title, anchor(title, place), section) for place, (title, section) in enumerate(parts)]


def anchor(title: str, place: int) -> str:
    """A name for links, unique by its place on the page."""
    return f"s{place}-" + (re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:40] or "part")
