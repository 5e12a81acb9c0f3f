"""camera.json: of a recording, and as the option --camera."""

from collections.abc import Iterator
from pathlib import Path

from broken import bases
from broken.case import ACCEPTED, EITHER, REFUSED, Case
from broken.crossing import Break, Edit, crossed, over_file
from broken.odd_files import NO_FILE, encodings
from broken.odd_values import LETTERS, NUMBERS, twice, whole, with_raw

READERS = ("info", "convert", "reconstruct", "evaluate", "turntable")
OPTION = {
    "info": ["info", "wall", "--camera", "FILE"],
    "convert": ["convert", "wall", "out", "--camera", "FILE"],
    "simulate": ["simulate", "wall", "--camera", "FILE", "-o", "out"],
    "scene": ["simulate", "FILE", "-o", "out"],
}
HERE = ("camera.json",)
GOOD = bases.CAMERA


def write(content: bytes) -> Edit:
    """Another camera.json."""
    return lambda rec: (rec / "camera.json").write_bytes(content)


def fields() -> Iterator[Break]:
    """One value is wrong."""
    for field in ("width", "fx", "cx", "depth_scale"):
        for name, raw in NUMBERS.items():
            yield Break(
                f"{field} {name}",
                write(with_raw(GOOD, (field,), raw)),
                REFUSED,
                HERE,
                quick=(field, name) in (("fx", "nan"), ("width", "400 digits")),
            )
    for field in ("width", "height", "fx", "fy", "depth_scale"):
        for raw in ("0", "-1", "-160"):
            yield Break(f"{field} {raw}", write(with_raw(GOOD, (field,), raw)), REFUSED, HERE)
    for field, raw in (
        ("fx", "1e300"),
        ("fx", "1e-300"),
        ("fy", "5e-324"),
        ("cx", "1e300"),
        ("depth_scale", "1e300"),
        ("depth_scale", "1e-300"),
        ("depth_scale", "1e-10"),
        ("width", "160.5"),
        ("width", "1e9"),
        ("width", "2147483648"),
        ("height", "99999999999999999999"),
    ):
        yield Break(
            f"{field} {raw}",
            write(with_raw(GOOD, (field,), raw)),
            REFUSED,
            (*HERE, "000000.png"),
            quick=raw == "1e-300",
        )
    for name, raw in {
        "two values": "[0, 0]",
        "nine values": "[0,0,0,0,0,0,0,0,0]",
        "nan inside": "[0, NaN, 0, 0, 0]",
        "a word inside": '[0, "x", 0, 0, 0]',
        "1e300": "[1e300, 0, 0, 0, 0]",
        "lists inside": "[[0], 0, 0, 0, 0]",
        "an object": '{"k1": 0}',
        "a word": '"none"',
    }.items():
        yield Break(f"distortion {name}", write(with_raw(GOOD, ("distortion",), raw)), REFUSED, HERE)
    for field in ("width", "height", "fx", "fy", "cx", "cy"):
        yield Break(f"no {field}", write(_without(field)), REFUSED, HERE)
    yield Break("no depth_scale", write(_without("depth_scale")), EITHER, HERE)
    yield Break("principle unknown to all", write(with_raw(GOOD, ("principle",), '"sonar"')), REFUSED, HERE)
    yield Break(
        "half the width",
        write(with_raw(GOOD, ("width",), "80")),
        REFUSED,
        (*HERE, "000000.png"),
        ("convert", "reconstruct", "evaluate", "turntable"),
    )
    for field, raw in (
        ("std", '{"fx": -1}'),
        ("std", '{"fx": NaN}'),
        ("std", "5"),
        ("std", '{"fx": "wide"}'),
        ("serial", "{}"),
        ("sensor", "[1]"),
        ("color", "5"),
        ("color", '{"width": 160}'),
        ("color", "[]"),
    ):
        yield Break(f"{field} {raw}", write(with_raw(GOOD, (field,), raw)), REFUSED, HERE)


def _without(field: str) -> bytes:
    import json

    return json.dumps({key: value for key, value in GOOD.items() if key != field}).encode()


def color() -> Iterator[Break]:
    """The colour camera's block and its pose."""
    plain = {key: GOOD[key] for key in ("width", "height", "fx", "fy", "cx", "cy", "distortion")}
    unit = [[1, 0, 0, 0.02], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    poses = {
        "3 x 4": unit[:3],
        "flat": [x for row in unit for x in row],
        "zeros": [[0] * 4] * 4,
        "scaled": [[2 * x for x in row] for row in unit],
        "mirrored": [[-1, 0, 0, 0], *unit[1:]],
        "a word": [["x", 0, 0, 0], *unit[1:]],
        "ragged": [[1, 0, 0], *unit[1:]],
        "last row": [*unit[:3], [0, 0, 1, 1]],
        "sheared": [[1, 0.5, 0, 0], *unit[1:]],
    }
    for name, pose in poses.items():
        told = GOOD | {"color": plain | {"T_color_depth": pose}}
        yield Break(
            f"T_color_depth {name}",
            lambda rec, told=told: bases.write_json(rec / "camera.json", told),
            REFUSED,
            HERE,
            of="turntable",
        )  # type: ignore[misc]
    raw = with_raw(GOOD | {"color": plain | {"T_color_depth": unit}}, ("color", "T_color_depth", 0, 3), "NaN")
    yield Break("T_color_depth nan", write(raw), REFUSED, HERE, of="turntable")


def texts() -> Iterator[Break]:
    """The whole text is wrong, or only written otherwise."""
    for name, content in whole(GOOD):
        yield Break(name, write(content), REFUSED, HERE, quick=name in ("a list", "100,000 lists"))
    text = (bases.place() / "wall" / "camera.json").read_bytes()
    for name, content in encodings(text):
        expected = {
            "BOM": ACCEPTED,
            "CRLF": ACCEPTED,
            "CR": ACCEPTED,
            "Latin-1": REFUSED,
            "surrogates": REFUSED,
            "NUL after each line": REFUSED,
        }
        yield Break(name, write(content), expected.get(name, EITHER), HERE)
    yield Break("width twice", write(twice(GOOD, "width", "80")), EITHER, HERE)
    yield Break(
        "a name with escape codes",
        lambda rec: bases.write_json(rec / "camera.json", GOOD | {"sensor": LETTERS, "serial": LETTERS}),
        EITHER,
        HERE,
        quick=True,
    )
    yield Break(
        "a name of 5 kB", lambda rec: bases.write_json(rec / "camera.json", GOOD | {"sensor": "x" * 5000}), EITHER, HERE
    )
    yield Break(
        "principle of 5 kB",
        lambda rec: bases.write_json(rec / "camera.json", GOOD | {"principle": "x" * 5000}),
        REFUSED,
        HERE,
    )
    yield Break(
        "principle with escape codes",
        lambda rec: bases.write_json(rec / "camera.json", GOOD | {"principle": LETTERS}),
        REFUSED,
        HERE,
    )
    yield Break(
        "unknown keys",
        lambda rec: bases.write_json(rec / "camera.json", GOOD | {"more": [1, {"a": None}], "": 3}),
        ACCEPTED,
        HERE,
    )
    yield Break(
        "a million keys",
        lambda rec: bases.write_json(rec / "camera.json", GOOD | {f"k{n}": n for n in range(1_000_000)}),
        EITHER,
        HERE,
    )


def odd() -> Iterator[Break]:
    """No file in its place."""
    for name, put in NO_FILE.items():
        if name != "no file":  # which makes it plain TUM
            yield Break(name, lambda rec, put=put: put(rec / "camera.json"), REFUSED, HERE)  # type: ignore[misc]
    yield Break("a link out", _out, REFUSED, HERE)


def _out(rec: Path) -> None:
    bases.write_json(rec.parent / "outside" / "real.json", GOOD)
    (rec / "camera.json").unlink()
    (rec / "camera.json").symlink_to("../outside/real.json")


def cases() -> Iterator[Case]:
    yield from crossed("camera.json", [*fields(), *color(), *texts(), *odd()], READERS)
    chosen = {
        "fx nan": with_raw(GOOD, ("fx",), "NaN"),
        "width 400 digits": with_raw(GOOD, ("width",), "9" * 400),
        "empty": b"",
        "a list": b"[]",
        "100,000 lists": b"[" * 100_000,
        "UTF-16": '{"width": 160}'.encode("utf-16"),
        "a mesh": b"ply\nformat ascii 1.0\n",
    }
    for name, content in chosen.items():
        yield from over_file("--camera", f"{name} camera.json", content, OPTION, expected=REFUSED)
    for name, put in NO_FILE.items():
        yield from over_file("--camera is", f"{name} camera.json", put, {"info": OPTION["info"]}, expected=REFUSED)
