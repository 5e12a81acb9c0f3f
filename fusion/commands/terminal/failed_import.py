"""A library that cannot be imported, told in one line: what is missing and which command brings it."""

import re
from collections.abc import Iterator

from fusion.commands.terminal.system_libraries import PACKAGES, install_command, missing_libraries, packages_of
from fusion.errors import FusionError

# as the loader of Linux says it
_NOT_FOUND = re.compile(r"(\S+\.so\S*): cannot open shared object file")
_INSTALL_AGAIN = "install it again: rm -r .venv && make environment, or pip install --force-reinstall fusion-scan"


def failed_import(error: ImportError | OSError) -> FusionError | None:
    """What to tell the user; None where no library of others failed to load."""
    chain = list(_chain(error))
    for each in chain:
        if found := _NOT_FOUND.search(str(each)):
            return _missing(found[1], _library(chain))
    name = _library(chain)
    if not isinstance(error, ImportError) or name == "fusion":
        return None  # a slip of our own is not to be hidden
    if isinstance(error, ModuleNotFoundError) and error.name == name:
        return FusionError(f"the Python package {name} is not installed", do=_INSTALL_AGAIN)
    reason = next(filter(None, str(chain[-1]).splitlines()), type(error).__name__)
    return FusionError(f"the Python package {name or 'needed'} cannot be loaded", found=reason, do=_INSTALL_AGAIN)


def _missing(library: str, name: str) -> FusionError:
    """Every missing library at once, so that one command is enough."""
    all_missing = sorted({library, *missing_libraries()})
    what = f"{name or 'a Python package'} cannot be loaded: the system lacks {', '.join(all_missing)}"
    if library in PACKAGES:
        return FusionError(what, do=f"install it: {install_command(packages_of(all_missing))}")
    return FusionError(what, do=f"install the package of your system that holds {library}")


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """The error and those that caused it."""
    while error is not None:
        yield error
        error = error.__cause__ or (None if error.__suppress_context__ else error.__context__)


def _library(chain: list[BaseException]) -> str:
    """Name of the package that was being imported, empty where no error says it."""
    names = (error.name for error in chain if isinstance(error, ImportError) and error.name)
    return next(names, "").split(".")[0]
