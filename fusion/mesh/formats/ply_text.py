"""The body of a PLY file that is text: a line for each row."""

import numpy as np
from numpy.typing import NDArray

from fusion.files.reading import decoded
from fusion.mesh.formats.ply_content import Content, wanted_list
from fusion.mesh.formats.ply_header import Element, Header, Property
from fusion.mesh.formats.rows import Lines, filled, table, told, whole


def read_text_body(header: Header, data: bytes) -> Content:
    lines = filled(decoded(data[header.start :]))
    lines = [(number + header.lines, line) for number, line in lines] if lines else lines
    content, at = Content(), 0
    for element in header.elements:
        rows = lines[at : at + element.count]
        if len(rows) < element.count:
            raise ValueError(f"{len(rows)} of {element.count} lines of element {element.name[:40]}")
        at += element.count
        if element.has_list:
            _text_lists(element, rows, content)
        elif element.name == "vertex":
            values = table(rows, len(element.properties))
            content.vertex = {one.name: _cast(values[:, i], one, rows) for i, one in enumerate(element.properties)}
    if at < len(lines):
        raise ValueError(told(*lines[at], "the end of the file"))
    return content


def _cast(values: NDArray[np.float64], about: Property, rows: Lines) -> NDArray:
    if about.type[0] == "f":
        with np.errstate(over="ignore"):
            return values.astype(about.type)
    integers, limits = whole(values, rows), np.iinfo(about.type)
    if len(integers) and (integers.min() < limits.min or integers.max() > limits.max):
        wrong = int(np.argmax((integers < limits.min) | (integers > limits.max)))
        raise ValueError(told(*rows[wrong], f"{about.name[:40]} from {limits.min} to {limits.max}"))
    return integers.astype(about.type)


def _text_lists(element: Element, rows: Lines, content: Content) -> None:
    """Rows with lists: those of equal structure are read together."""
    wanted = wanted_list(element)
    groups: dict[tuple[int, ...], Lines] = {}
    for number, line in rows:
        words, at, shape = line.split(), 0, []
        for one in element.properties:
            length = 1
            if one.length:
                count = words[at] if at < len(words) else ""
                if not count.isascii() or not count.isdigit() or len(count) > 9:
                    raise ValueError(told(number, line, "the length of a list and its numbers"))
                length, at = int(count), at + 1
            shape.append(length)
            at += length
        if at != len(words):
            raise ValueError(told(number, line, f"{at} numbers"))
        groups.setdefault(tuple(shape), []).append((number, line))
    for lengths, same in groups.items():
        lists = [bool(one.length) for one in element.properties]
        values = table(same, sum(lengths) + sum(lists))
        if wanted is not None:
            place = element.properties.index(wanted)
            at = sum(lengths[:place]) + sum(lists[: place + 1])
            content.faces.append(whole(values[:, at : at + lengths[place]], same))
        elif element.name == "vertex":
            raise ValueError("lists among the vertices, which are not read")
