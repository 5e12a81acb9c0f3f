"""Transforms of passes that are known from elsewhere: the `T_merged_pass` of a `merge.json`."""

from pathlib import Path

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from fusion.errors import FusionError
from fusion.files.content import Content, Rigid
from fusion.files.json_file import read_json
from fusion.geometry.pose import is_rigid


class PassRow(Struct):
    """One pass."""

    T_merged_pass: Rigid


class MergeFile(Struct):
    """What is needed of `merge.json`."""

    passes: list[PassRow]


def read_transforms(path: Path) -> NDArray[np.float64]:
    """Transforms (passes, 4, 4) to one common frame.

    Raises:
        FusionError: the file holds none, or one that is no rigid motion.
    """
    told = Content(read_json(path, what="the file of transforms"), path, "the file of transforms").as_type(MergeFile)
    found = np.array([row.T_merged_pass for row in told.passes], float).reshape(-1, 4, 4)
    for k, T in enumerate(found, 1):
        if not is_rigid(T):
            raise FusionError("a transform is no rigid motion", path, f"T_merged_pass of pass {k}", "a 4x4 pose")
    return found
