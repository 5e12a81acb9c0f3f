"""JSON texts that are wrong as a whole, and values that are wrong in a field."""

import json
from collections.abc import Iterator

# written into the text as they are: JSON has no way to say some of them
NUMBERS = {
    "nan": "NaN",
    "inf": "Infinity",
    "minus inf": "-Infinity",
    "1e999": "1e999",
    "minus 1e300": "-1e300",
    "400 digits": "9" * 400,
    "6000 digits": "1" * 6000,
    "a word": '"wide"',
    "a number as text": '"160"',
    "null": "null",
    "a list": "[160]",
    "an object": "{}",
    "yes": "true",
}
LETTERS = "\x1b[31mred\x1b[0m \x07\x9b \u202egnp \u2028 end"  # escapes, bell, C1, turned writing, a line's end


def whole(good: dict) -> Iterator[tuple[str, bytes]]:
    """Texts that are no such object, each to be refused."""
    text = json.dumps(good)
    yield "a list", b"[]"
    yield "a number", b"5"
    yield "null", b"null"
    yield "a string", b'"text"'
    yield "an empty object", b"{}"
    yield "blank", b" \n"
    yield "comma at the end", (text[:-1] + ",}").encode()
    yield "a comment", ("// comment\n" + text).encode()
    yield "single quotes", text.replace('"', "'").encode()
    yield "two objects", (text + text).encode()
    yield "NUL after it", text.encode() + b"\0"
    yield "a PNG", b"\x89PNG\r\n\x1a\n" + bytes(range(256))
    yield "no UTF-8", text.replace("{", '{"note": "\udcff", ', 1).encode("utf-8", "surrogateescape")
    yield "100,000 lists", b"[" * 100_000
    yield "100,000 lists in a key", (text[:-1] + ', "x": ').encode() + b"[" * 100_000 + b"]" * 100_000 + b"}"
    yield (
        "100,000 objects in a key",
        (text[:-1] + ', "x": ').encode() + b'{"a":' * 100_000 + b"1" + b"}" * 100_000 + b"}",
    )
    for n in (1, 2, 3):
        yield f"cut at {n}/4", text[: len(text) * n // 4].encode()


def with_raw(good: dict, path: tuple[str | int, ...], raw: str) -> bytes:
    """The object's text with one value, found by its keys, replaced by raw text."""
    mark = "@@VALUE@@"
    told = json.loads(json.dumps(good))
    inner = told
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = mark
    return json.dumps(told).replace(f'"{mark}"', raw).encode()


def twice(good: dict, key: str, raw: str) -> bytes:
    """The object's text with one key given a second time, before the good one."""
    return ("{" + f'"{key}": {raw}, ' + json.dumps(good)[1:]).encode()
