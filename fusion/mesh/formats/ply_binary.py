"""The body of a PLY file that is binary."""

import numpy as np
from numpy.typing import NDArray

from fusion.mesh.formats.ply_content import Content, wanted_list
from fusion.mesh.formats.ply_header import Element, Header

PADDING = b" \t\r\n\0"  # what may follow the last element
STEP = 1_000_000  # bytes that are gathered at once


def read_binary_body(header: Header, data: bytes) -> Content:
    content, at = Content(), header.start
    for element in header.elements:
        if element.has_list:
            if element.name == "vertex":
                raise ValueError("lists among the vertices, which are not read")
            if element.count * _least(element) > len(data) - at:
                raise ValueError(
                    f"{element.count} of element {element.name[:40]} promised, for which the file is short"
                )
            at = _binary_lists(element, header.order, data, at, content)
            continue
        row = np.dtype([(one.name, header.order + one.type) for one in element.properties])
        end = at + element.count * row.itemsize
        if end > len(data):
            raise ValueError(f"{(len(data) - at) // row.itemsize} of {element.count} of element {element.name[:40]}")
        if element.name == "vertex":
            rows = np.frombuffer(data, row, element.count, at)
            content.vertex = {one.name: rows[one.name].astype(one.type) for one in element.properties}
        at = end
    if data[at:].strip(PADDING):
        raise ValueError(f"{len(data) - at} bytes more than the header promises")
    return content


def _binary_lists(element: Element, order: str, data: bytes, at: int, content: Content) -> int:
    """Reads the list that is wanted; returns where the element ends."""
    wanted = wanted_list(element)
    regular = _regular(element, order, data, at)
    if regular is not None:
        if wanted is not None:
            content.faces.append(regular[wanted.name])
        return at + regular.nbytes
    # lists of different lengths: where each one is, then those of equal length together
    starts, lengths = np.empty(element.count, np.int64), np.empty(element.count, np.int64)
    sizes = [
        (np.dtype(one.type).itemsize, np.dtype(one.length).itemsize * bool(one.length)) for one in element.properties
    ]
    for row in range(element.count):
        for one, (size, length) in zip(element.properties, sizes, strict=True):
            count = 1
            if one.length:
                count = int.from_bytes(
                    data[at : at + length], "big" if order == ">" else "little", signed=one.length[0] == "i"
                )
                at += length
            if count < 0 or at + count * size > len(data):
                raise ValueError(f"{row} of {element.count} of element {element.name[:40]}")
            if one is wanted:
                starts[row], lengths[row] = at, count
            at += count * size
    if wanted is not None:
        content.faces += _gathered(data, starts, lengths, np.dtype(order + wanted.type))
    return at


def _regular(element: Element, order: str, data: bytes, at: int) -> NDArray | None:
    """All rows at once where each list has one length in all of them, as it is with triangles; else None."""
    fields: list[tuple] = []
    for number, one in enumerate(element.properties):
        shape: tuple[int, ...] = ()
        if one.length:
            if one.length[0] == "f":
                raise ValueError("a list whose length is no whole number")
            kind = np.dtype(order + one.length)
            offset = at + (np.dtype(fields).itemsize if fields else 0)
            if offset + kind.itemsize > len(data):
                return None
            shape = (int(np.frombuffer(data, kind, 1, offset)[0]),)
            if shape[0] < 0 or shape[0] > len(data):
                return None
            fields.append((f"length {number}", kind))
        fields.append((one.name, order + one.type, shape))
    row = np.dtype(fields)
    if at + element.count * row.itemsize > len(data):
        return None
    rows = np.frombuffer(data, row, element.count, at)
    lengths = [name for name, *_ in fields if name.startswith("length ")]
    return rows if all(len(rows) == 0 or (rows[name] == rows[name][0]).all() for name in lengths) else None


def _least(element: Element) -> int:
    """Bytes of a row whose lists are empty."""
    return sum(np.dtype(one.length or one.type).itemsize for one in element.properties)


def _gathered(data: bytes, starts: NDArray, lengths: NDArray, kind: np.dtype) -> list[NDArray]:
    """Lists that begin at these bytes, in groups (k, length) of equal length."""
    every, found = np.frombuffer(data, np.uint8), []
    for length in np.unique(lengths):
        begin = starts[lengths == length]
        width = int(length) * kind.itemsize
        step = max(1, STEP // max(width, 1))
        parts = [every[begin[i : i + step, None] + np.arange(width)] for i in range(0, len(begin), step)]
        found.append(np.concatenate(parts).view(kind).reshape(len(begin), length))
    return found
