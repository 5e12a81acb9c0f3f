"""What a run told its user: exit status, terminal, settings.json, turntable.json, and the text of the page."""

import html.parser
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LIMIT = 600  # [s] for one scan


@dataclass(frozen=True)
class Light:
    """One entry of the judgement."""

    level: str
    subject: str
    reason: str

    @property
    def text(self) -> str:
        return f"{self.subject}: {self.reason}"


@dataclass(frozen=True)
class Said:
    """Everything outward.

    Attributes:
        lights: settings.json's "judgement"; None where it has none.
        refined: turntable.json's camera.refined.
    """

    status: int
    terminal: str
    lights: tuple[Light, ...] | None
    warnings: tuple[str, ...]
    verdict: str
    reasons: tuple[str, ...]
    refined: bool
    page: str
    mesh: Path | None
    seconds: float


def run(recording: Path, output: Path) -> Said:
    """Scan as a user would, with nothing but the recording, and read what came of it."""
    begin = time.monotonic()
    program = "from fusion.commands.main import main; raise SystemExit(main())"
    command = [sys.executable, "-c", program, "turntable", str(recording), "-o", str(output)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LIMIT)
        status, terminal = done.returncode, done.stderr + done.stdout
    except subprocess.TimeoutExpired:
        status, terminal = -1, f"no end within {LIMIT} s"
    return read(output, status, terminal, time.monotonic() - begin)


def read(output: Path, status: int, terminal: str, seconds: float) -> Said:
    settings, turntable = _json(output / "settings.json"), _json(output / "turntable.json")
    told = settings.get("judgement")
    lights = None if told is None else tuple(Light(*(str(x[k]) for k in ("level", "subject", "reason"))) for x in told)
    page, mesh = output / "report.html", output / "mesh.ply"
    return Said(
        status,
        terminal,
        lights,
        tuple(str(w) for w in settings.get("warnings", ())),
        str(turntable.get("verdict", "")),
        tuple(turntable.get("reasons", ())),
        bool(turntable.get("camera", {}).get("refined", False)),
        visible_text(page.read_text(encoding="utf-8")) if page.is_file() else "",
        mesh if mesh.is_file() else None,
        seconds,
    )


def _json(file: Path) -> dict[str, Any]:
    return dict(json.loads(file.read_text(encoding="utf-8"))) if file.is_file() else {}


class _Words(html.parser.HTMLParser):
    """Text outside scripts, styles and heads."""

    SILENT = ("script", "style", "template", "title")

    def __init__(self) -> None:
        super().__init__()
        self.words: list[str] = []
        self.hidden = 0

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.hidden += tag in self.SILENT

    def handle_endtag(self, tag: str) -> None:
        self.hidden -= tag in self.SILENT

    def handle_data(self, data: str) -> None:
        if not self.hidden:
            self.words.append(data)


def visible_text(page: str) -> str:
    reader = _Words()
    reader.feed(page)
    return squeezed(" ".join(reader.words))


def squeezed(text: str) -> str:
    """One space between words: how a terminal or a page breaks its lines does not matter."""
    return " ".join(text.split())
