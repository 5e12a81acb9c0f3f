"""board.json: the board before the camera."""

import json
from collections.abc import Iterator

from broken import bases
from broken.case import REFUSED, Case
from broken.crossing import over_file
from broken.inputs.scenes import texts
from broken.odd_files import NO_FILE
from broken.odd_values import LETTERS, NUMBERS, with_raw


def boards() -> Iterator[Case]:
    run = {"intrinsics": ["calibrate", "intrinsics", "checkerboard", "--board", "FILE", "-o", "out", "--no-report"]}
    depth = {"depth": ["calibrate", "depth", "checkerboard", "--board", "FILE", "-o", "out", "--no-report"]}
    good = bases.BOARD
    for name, content, expected in texts(good):
        if name not in ("good", "mesh twice"):
            yield from over_file(
                "board",
                f"{name} board.json",
                content,
                run | (depth if name in ("BOM", "a list") else {}),
                expected=expected,
            )
    for field in ("columns", "square_m"):
        for raw in [*NUMBERS.values(), "0", "-1", "1e9", "1e-300"]:
            yield from over_file(
                "board", f"{field} {raw[:20]} board.json", with_raw(good, (field,), raw), run, expected=REFUSED
            )
    marked = good | {"marker_m": 0.02, "dictionary": "DICT_5X5_100"}
    for field, raw in (
        ("dictionary", '"DICT_MAGIC"'),
        ("dictionary", '"__class__"'),
        ("dictionary", "5"),
        ("dictionary", json.dumps(LETTERS)),
        ("dictionary", json.dumps("x" * 5000)),
        ("marker_m", "0"),
        ("marker_m", "1"),
        ("marker_m", "NaN"),
        ("marker_m", "-0.01"),
        ("columns", "1000"),
        ("dictionary", '"imread"'),
    ):
        yield from over_file(
            "board", f"{field} {raw[:20]!r} board.json", with_raw(marked, (field,), raw), run, expected=REFUSED
        )
    for name, put in NO_FILE.items():
        yield from over_file("board is", f"{name} board.json", put, run, expected=REFUSED)


def cases() -> Iterator[Case]:
    yield from boards()
