"""Names that a recording or a scene gives to its files: they stay inside its folder."""

from pathlib import Path

from fusion.errors import FusionError

OPTION = "--follow-links"

_follow = False


def follow_links() -> None:
    """From now on, in this process, names may lead out of their folder: for the console program, when it is asked."""
    global _follow
    _follow = True


def inside(folder: Path, name: str, error: type[FusionError] = FusionError, where: object = "") -> Path:
    """The path of a file that a text in `folder` names; also where a link leads must lie in that folder.

    Args:
        folder: what the name is relative to.
        name: as it stands in the file.
        error: the kind of error to raise.
        where: the file that names it, for the message; the folder when it is left out.

    Raises:
        FusionError: of the kind asked for: the name leads out of the folder.
    """
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
