"""The header of a PLY file: what it promises."""

import re
from dataclasses import dataclass

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float16": "f2", "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_START = re.compile(rb"ply[ \t]*(\r\n|\n|\r)", re.IGNORECASE)
_MOST = 1_000_000  # bytes of a header


@dataclass(frozen=True)
class Property:
    """One value of an element, or a list of them: numpy's types of the value and of the list's length ("" for none)."""

    name: str
    type: str
    length: str = ""


@dataclass(frozen=True)
class Element:
    """`count` rows of these properties."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def has_list(self) -> bool:
        """True where rows may be of different lengths."""
        return any(one.length for one in self.properties)


@dataclass(frozen=True)
class Header:
    """What the file promises.

    Attributes:
        order: "" for text, "<" or ">" for the byte order.
        elements: in the file's order.
        start: where the body begins [bytes].
        lines: of the header.
    """

    order: str
    elements: tuple[Element, ...]
    start: int
    lines: int


def read_header(data: bytes) -> Header:
    """The header at the start of a PLY file; ValueError where it is none."""
    begin = _START.match(data)
    end = begin and re.compile(re.escape(begin[1]) + rb"end_header[ \t]*" + re.escape(begin[1])).search(data, 0, _MOST)
    if not begin or not end:
        raise ValueError(f"no PLY header: {data[:8]!r}" if not begin else "a PLY header without its end")
    try:
        lines = data[: end.start()].decode("utf-8").split(begin[1].decode())
    except UnicodeDecodeError:
        raise ValueError("a header that is not text") from None
    order, elements = None, []  # type: ignore[var-annotated]
    for number, line in enumerate(lines[1:], start=2):
        match line.split():
            case [] | ["comment" | "obj_info", *_]:
                pass
            case ["format", kind, _] if kind in ORDERS and order is None:
                order = ORDERS[kind]
            case ["element", name, count] if re.fullmatch(r"[0-9]{1,15}", count):
                elements.append((name, int(count), []))
            case ["property", "list", length, kind, name] if elements and {length, kind} <= set(TYPES):
                elements[-1][2].append(Property(name, TYPES[kind], TYPES[length]))
            case ["property", kind, name] if elements and kind in TYPES:
                elements[-1][2].append(Property(name, TYPES[kind]))
            case _:
                raise ValueError(f"line {number} of the header: {line[:40]!r}")
    if order is None:
        raise ValueError("a header without format")
    made = tuple(Element(name, count, tuple(properties)) for name, count, properties in elements)
    _refuse_doubles(made)
    return Header(order, made, end.end(), len(lines) + 1)


def _refuse_doubles(elements: tuple[Element, ...]) -> None:
    for names in ([one.name for one in elements], *([p.name for p in one.properties] for one in elements)):
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"{name[:40]!r} twice in the header")
    if not any(one.name == "vertex" for one in elements):
        raise ValueError("no element vertex")
    if any(one.name == "tristrips" and one.count for one in elements):
        raise ValueError("triangle strips, which are not read")
    bare = next((one.name for one in elements if one.count and not one.properties), None)
    if bare is not None:
        raise ValueError(f"element {bare[:40]} without a property")
