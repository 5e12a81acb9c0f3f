"""The folder of a batch: it may be new, empty, or that of an earlier batch, which goes on there."""

import json
from collections.abc import Iterable
from pathlib import Path

from fusion import __version__
from fusion.files.output.claim import MARK, refuse_input, refuse_other_kind, replaceable
from fusion.files.output.publish import atomic_file, place_of
from fusion.files.output.refused import told
from fusion.files.output.staging import staging

COMMAND = "batch"


def check_place(path: Path, inputs: Iterable[Path]) -> None:
    """Refuse a folder that holds what no batch made, or that is, holds or lies in what is read. Raises FusionError."""
    place = place_of(path)
    refuse_other_kind(path, place, folder=True)
    for given in inputs:
        refuse_input(path, place, Path(given))
    with told(path):
        replaceable(path, place, COMMAND, overwrite=True)
        with staging(place):  # asks whether anything can be written there
            pass


def mark(home: Path) -> None:
    """Say whose the folder is. Raises FusionError: it cannot be written."""
    content = {"command": COMMAND, "fusion": __version__, "files": []}
    with atomic_file(home / MARK) as partial:
        partial.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
