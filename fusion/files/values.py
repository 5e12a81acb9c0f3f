"""Kinds of values that several files hold; bounds keep out what cannot be meant and would not be computable."""

from typing import Annotated

from msgspec import Meta

FARTHEST_M = 1e7  # of a place: the coordinates of any map on Earth

Name = Annotated[str | int | None, Meta(description="for people")]
Whole = Annotated[float, Meta(multiple_of=1)]  # a float: 640.0 is a whole number in JSON
FileName = Annotated[str, Meta(min_length=1, description="a file's name")]
Metres = Annotated[float, Meta(gt=-FARTHEST_M, lt=FARTHEST_M)]
Point = Annotated[tuple[Metres, Metres, Metres], Meta(description="three numbers [m], below 1e7")]
_Row = tuple[Metres, Metres, Metres, Metres]
Rigid = Annotated[tuple[_Row, _Row, _Row, _Row], Meta(description="a rigid 4x4 matrix, metres, below 1e7")]
