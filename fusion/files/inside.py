"""Names that a recording or a scene gives to its files: they stay inside its folder."""

import os
from collections.abc import Iterable
from pathlib import Path

from fusion.errors import FusionError

OPTION = "--follow-links"
LONGEST = 4096  # bytes of a path that Linux takes; others take fewer

_follow = False


def follow_links(follow: bool) -> None:
    """From now on, in this process, names may lead out of their folder, or not."""
    global _follow
    _follow = follow


def inside(folder: Path, name: str, error: type[FusionError] = FusionError, where: object = "") -> Path:
    """The path of a file that a text in `folder` names; also where a link leads must lie in that folder.

    Args:
        where: the file that names it, for the message; the folder when it is left out.

    Raises:
        FusionError: of the kind asked for: the name leads out of the folder, or is no possible one.
    """
    _short(folder, name, error, where)
    path = folder / name
    if not _follow:
        try:
            home, end = folder.resolve(), path.resolve()
        except (OSError, ValueError, RuntimeError) as problem:  # a null byte, a loop of links
            raise error(
                "a name of a file cannot be used", where or folder, repr(name)[:80], "a file's name"
            ) from problem
        if home != end and home not in end.parents:
            do = f"if you trust it, pass {OPTION}"
            raise error(
                "a file lies outside its folder", where or folder, repr(name)[:80], f"a name inside {folder}", do
            )
    return path


def part(folder: Path, name: str, error: type[FusionError]) -> Path | None:
    """The path of a part that a folder may have, or None where it has none. Raises as `inside`."""
    return inside(folder, name, error) if os.path.lexists(folder / name) else None


def all_inside(
    folder: Path, names: Iterable[str], error: type[FusionError] = FusionError, where: object = ""
) -> list[str]:
    """The same for many names, which come back: each folder among them is looked at once, each file for a link only.

    Raises:
        FusionError: as `inside`, for the first name that leads out.
    """
    names = list(names)
    _short(folder, max(names, key=len, default=""), error, where)
    if _follow:
        return names
    links: dict[str, set[str]] = {}
    for name in names:
        parent, _, last = name.rpartition("/")
        if parent not in links:
            inside(folder, name, error, where)
            links[parent] = _links(folder / parent)
        if last in links[parent] or last == "..":
            inside(folder, name, error, where)
    return names


def _short(folder: Path, name: str, error: type[FusionError], where: object) -> None:
    if len(name) > LONGEST:
        found = f"{name[:20]!r} and {len(name) - 20} letters more"
        raise error("a name of a file is too long", where or folder, found, f"at most {LONGEST}")


def _links(folder: Path) -> set[str]:
    """The names in a folder that are links; none where there is no folder."""
    try:
        with os.scandir(folder) as entries:
            return {entry.name for entry in entries if entry.is_symlink()}
    except OSError:
        return set()
