"""What is in files, as one short word: equal content, equal word, wherever it lies."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from fusion.errors import FusionError
from fusion.files.json_file import read_json

CHUNK = 1 << 20  # bytes


def fingerprint(path: Path | str) -> str:
    """Of a file's content, or of a folder's: names and contents of all files, but for hidden ones.

    Files that a JSON file names beside itself count with it: maps of a sensor, the mesh of a scene.

    Raises:
        OSError: something cannot be read.
    """
    path, digest = Path(path), hashlib.blake2b(digest_size=16)
    for inner in _files(path) if path.is_dir() else _with_named(path):
        name = inner.relative_to(path).as_posix() if path.is_dir() else inner.name
        digest.update(f"{name}\n{inner.stat().st_size}\n".encode("utf-8", "surrogateescape"))
        with inner.open("rb") as file:
            while chunk := file.read(CHUNK):
                digest.update(chunk)
    return digest.hexdigest()


def key_of(version: str, words: list[str], files: dict[str, str]) -> str:
    """The key of a job: of the program's version, its words, and of what is in the files that they name.

    Args:
        files: word to fingerprint: their content counts, and not where they lie.
    """
    content = json.dumps([version, [files.get(word, word) for word in words]])
    return hashlib.blake2b(content.encode("utf-8", "surrogateescape"), digest_size=16).hexdigest()


def _files(folder: Path) -> list[Path]:
    found = []
    for inner, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found += [Path(inner, name) for name in sorted(names) if not name.startswith(".")]
    return [path for path in found if path.is_file()]


def _with_named(path: Path) -> list[Path]:
    if path.suffix != ".json":
        return [path]
    try:
        content = read_json(path)
    except FusionError:  # the command will say it
        return [path]
    named = (path.parent / text for text in _texts(content) if text and len(text) < 256 and "\0" not in text)
    return [path, *sorted({one for one in named if one.is_file() and one != path})]


def _texts(value: Any) -> list[str]:
    if isinstance(value, str):
        return [value]
    inner = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    return [text for one in inner for text in _texts(one)]
