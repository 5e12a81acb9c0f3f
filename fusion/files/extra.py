"""Libraries that only some files need: loaded when such a file is met, else told with the command that helps."""

import importlib
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from fusion.errors import FusionError

DISTRIBUTION = "fusion-scan"


def version_of(package: str) -> str:
    """The version of an installed package; "" where it is not there. Nothing is imported."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def extra(module: str, name: str, what: str, where: object, error: type[FusionError] = FusionError) -> Any:
    """A module that one of the package's extras brings.

    Args:
        name: the extra, as `pip install "fusion-scan[name]"` takes it.
        what: what needs it, as the message begins.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as problem:
        do = f"""install it: pip install "{DISTRIBUTION}[{name}]\""""
        package = module.partition(".")[0]
        raise error(f"{what} needs the Python package {package}", where, "it is not installed", do=do) from problem
