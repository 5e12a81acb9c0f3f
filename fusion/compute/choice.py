"""Which kernels run: the tuned ones, or the plain ones of the room `plain`, which do the same one item at a time; and
which back end compiles them: Taichi, or its fork Quadrants.

The variable FUSION_KERNELS says it for the whole process, in words with commas between: `tuned` or `plain`, else a
processor runs the tuned ones, which were made for it, and a card the plain ones; and `quadrants`. The table below is
all there is to choose; plain ones are loaded when they are asked for, as their room lies below those that they stand in
for. The back end is chosen when it is imported, and stays.
"""

import functools
import os
from collections.abc import Callable
from importlib import import_module
from typing import Any, ParamSpec, TypeVar, cast

from fusion.errors import FusionError

P = ParamSpec("P")
R = TypeVar("R")

# what is tuned, and the plain one beside it: of the same arguments and results
TABLE = {
    "fusion.geometry.relief:relief": "fusion.plain.point_map:relief",
    "fusion.tracking.equations:equations": "fusion.plain.icp:equations",
    "fusion.volume.integration.allocate:allocate": "fusion.plain.blocks:allocate",
    "fusion.volume.integration.integrate:integrate": "fusion.plain.integration:integrate",
    "fusion.volume.raycasting.raycast:raycast": "fusion.plain.raycast:raycast",
    "fusion.volume.extraction.surface:extract": "fusion.plain.surface:extract",
    "fusion.turntable.model.cells:normal_equations": "fusion.plain.turntable:normal_equations",
}
WORDS = {"tuned", "plain", "quadrants"}
DEVICES = ("cpu", "cuda", "vulkan", "auto")  # where kernels may run
_default = "tuned"


def plain() -> bool:
    """Whether the plain kernels run. FusionError: FUSION_KERNELS says something else."""
    said = _said()
    return "plain" in said or (_default == "plain" and "tuned" not in said)


def run_plain() -> None:
    """From now on the plain ones run where nothing is said: what runs is a card."""
    global _default
    _default = "plain"


def quadrants() -> bool:
    """Whether Quadrants was asked for, to compile kernels in Taichi's place.

    Raises:
        FusionError: FUSION_KERNELS says something else.
    """
    return "quadrants" in _said()


def _said() -> set[str]:
    said = os.environ.get("FUSION_KERNELS") or ""
    words = set(said.split(",")) if said else set()
    if not words <= WORDS or {"tuned", "plain"} <= words:
        known = "tuned or plain, and quadrants after a comma"
        raise FusionError("unknown kernels", "FUSION_KERNELS", said, known, "leave it out")
    return words


def either(tuned: Callable[P, R]) -> Callable[P, R]:
    """Marks a function that has a plain one beside it in the table: each call goes to the one that was chosen."""
    name = f"{tuned.__module__}:{tuned.__name__}"

    @functools.wraps(tuned)
    def chosen(*args: P.args, **kwargs: P.kwargs) -> R:
        call = cast("Callable[P, R]", named(TABLE[name])) if plain() else tuned
        return call(*args, **kwargs)

    return chosen


@functools.cache
def named(name: str) -> Any:
    """What stands in a module under a name, "module:name"."""
    module, _, what = name.partition(":")
    return getattr(import_module(module), what)
