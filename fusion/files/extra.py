"""Libraries that only some files need: loaded when such a file is met, else told with the command that helps."""

import importlib
from typing import Any

from fusion.errors import FusionError

DISTRIBUTION = "fusion-scan"


def extra(module: str, name: str, what: str, where: object, error: type[FusionError] = FusionError) -> Any:
    """A module that one of the package's extras brings.

    Args:
        module: as it is imported.
        name: the extra, as `pip install "fusion-scan[name]"` takes it.
        what: what needs it, as the message begins.
        where: the file.
        error: the kind of error to raise.

    Raises:
        FusionError: of the kind `error`: the module is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as problem:
        do = f"""install it: pip install "{DISTRIBUTION}[{name}]\""""
        package = module.partition(".")[0]
        raise error(f"{what} needs the Python package {package}", where, "it is not installed", do=do) from problem
