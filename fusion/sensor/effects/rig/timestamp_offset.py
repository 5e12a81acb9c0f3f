"""Timestamp offset: the picture is older or newer than its time stamp says, so what moves stands elsewhere."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fusion.sensor.effect import Effect
from fusion.sensor.laws.surface import moved
from fusion.sensor.parameter import parameter
from fusion.sensor.view import Image, View


@dataclass(frozen=True)
class TimestampOffset(Effect):
    """The surface is seen where it stands `offset` after the stated time: moved by velocity * offset.

    Positive: the picture was taken later than stated, an object on a table has turned further than the encoder's
    entry for that time. Unchanged where the velocity or the normals are not known.
    """

    name: ClassVar[str] = "timestamp_offset"
    key: ClassVar[str] = "M4"
    formula: ClassVar[str] = "z_measured = z + offset (n . velocity) / (n . ray)"
    variables: ClassVar[tuple[str, ...]] = ("velocity", "incidence")
    not_corrected: ClassVar[str] = "one depth image does not tell how fast a surface moves"

    offset: float = parameter(
        "s",
        (-1.0, 1.0),
        "how much later than its time stamp the picture was taken",
        "first principles; 5 to 50 ms is from memory",
        typical=0.02,
        kind="scalar",
    )

    def bias(self, depth: Image, view: View) -> Image:
        if view.velocity is None:
            return np.zeros((), depth.dtype)
        return moved(depth, view.velocity, view) * self.offset
