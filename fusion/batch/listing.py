"""Which recordings a batch goes over: those in a folder, or those in a list."""

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fusion.errors import FusionError
from fusion.files.output.claim import MARK
from fusion.files.reading import read_text
from fusion.recording.formats.folders.plain import natural
from fusion.recording.open import recognised

REC = "rec"
LIST = "a CSV file with a column rec, or a folder of recordings"


@dataclass(frozen=True)
class Item:
    """One thing to work on."""

    named: str  # as the folder or the list names it
    path: Path  # where it is
    columns: Mapping[str, str] = field(default_factory=dict)  # further words of its line in the list, by their column


def items_in(place: Path | str) -> tuple[list[Item], list[str]]:
    """The items of a folder or a list, in their order, and what is left out of the folder, one sentence each.

    In a folder every folder is an item, also one that is no recording (its row will say so), but for results of fusion
    and hidden ones; of the files those that are recordings.

    Raises:
        FusionError: there is no such place, or nothing in it.
    """
    place = Path(place)
    if place.is_dir():
        found, notes = _in_folder(place)
    elif place.is_file():
        found, notes = _in_list(place), []
    else:
        raise FusionError("there is nothing to work on", place, "nothing" if not place.exists() else "no file", LIST)
    if not found:
        raise FusionError("there is nothing to work on", place, "no recording in it", LIST)
    return found, notes


def _in_folder(folder: Path) -> tuple[list[Item], list[str]]:
    found, notes = [], []
    for path in sorted(folder.iterdir(), key=lambda p: natural(p.name)):
        if path.name.startswith("."):
            continue
        if path.is_dir() and (path / MARK).is_file() and recognised(path) is None:
            notes.append(f"{path.name} is a result of fusion: left out")
        elif path.is_dir() or (path.is_file() and recognised(path) is not None):
            found.append(Item(path.name, path))
        else:
            notes.append(f"{path.name} is no recording: left out")
    return found, notes


def _in_list(path: Path) -> list[Item]:
    rows = csv.reader(io.StringIO(read_text(path, FusionError, "the list")))
    head = [name.strip() for name in next(rows, [])]
    if REC not in head or len(set(head)) != len(head):
        shown = ", ".join(head)[:80] or "nothing"
        raise FusionError("the list has no column rec, or one twice", path, shown, "a first line such as rec,reference")
    found: dict[str, Item] = {}
    for number, row in enumerate(rows, start=2):
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(head):
            raise FusionError("a line of the list cannot be read", f"{path}, line {number}", len(row), len(head))
        cells = dict(zip(head, (cell.strip() for cell in row), strict=True))
        named = cells.pop(REC)
        # what names a file is meant from where the list stands
        beside = {key: str(path.parent / cell) for key, cell in cells.items() if cell and (path.parent / cell).exists()}
        found.setdefault("\n".join([named, *cells.values()]), Item(named, path.parent / named, cells | beside))
    return list(found.values())
