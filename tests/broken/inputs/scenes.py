"""scene.json: to simulate, and as what a recording says of what was before the camera; board.json beside it."""

import json
from collections.abc import Iterator
from pathlib import Path

from broken import bases, meshes
from broken.case import ACCEPTED, EITHER, REFUSED, Case, Expected
from broken.crossing import Break, crossed, over_file
from broken.odd_files import NO_FILE, encodings, fifo, folder, link
from broken.odd_values import LETTERS, NUMBERS, twice, whole, with_raw

RUN = {"simulate": ["simulate", "FILE", "-o", "out"]}
READERS = ("explain", "simulate", "convert", "info")


def texts(good: dict) -> Iterator[tuple[str, bytes, Expected]]:
    for name, content in whole(good):
        yield name, content, REFUSED
    for name, content in encodings(json.dumps(good, indent=1).encode()):
        expected = {
            "BOM": ACCEPTED,
            "CRLF": ACCEPTED,
            "CR": ACCEPTED,
            "Latin-1": REFUSED,
            "surrogates": REFUSED,
            "NUL after each line": REFUSED,
        }
        yield name, content, expected.get(name, EITHER)
    yield "good", json.dumps(good).encode(), ACCEPTED
    yield "mesh twice", twice(good, "mesh", '"other.ply"'), EITHER


def values() -> Iterator[tuple[tuple[str | int, ...], str, Expected]]:
    """A value of a scene to simulate, by its keys."""
    table = ("trajectory", "turntable")
    for raw in NUMBERS.values():
        fine = raw in ("null",)
        yield (*table, "degrees_per_frame"), raw, REFUSED
        yield ("reflectance",), raw, EITHER if fine else REFUSED
    for raw in ("0", "-3", "1e9", "2.5", "NaN", '"many"', "99999999999999999999"):
        yield (*table, "frames"), raw, REFUSED
    for raw in ("[0, 0, 0]", "[0, 0]", "[NaN, 0, 1]", '"up"', "[0, 0, 1e300]", "5"):
        yield (*table, "axis_direction"), raw, EITHER if "e300" in raw else REFUSED
    for raw in ("[1e300, 0, 0]", "[0, 0, Infinity]", "[]", "null"):
        yield (*table, "axis_point"), raw, EITHER if raw == "null" else REFUSED
    for raw in ("2", "-0.5", "1e300"):
        yield ("reflectance",), raw, REFUSED
    for raw in (
        "[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]",
        "[0,0,0,0,0,0,0]",
        "[0,0,0]",
        '{"eye": [0,0,0], "target": [0,0,0]}',
        '{"eye": [0,0,1], "target": [0,0,0]}',
        '{"eye": [1e300,0,0], "target": [0,0,0]}',
        '{"eye": [NaN,0,0], "target": [0,0,0]}',
        '"here"',
        "[[2,0,0,0],[0,2,0,0],[0,0,2,0],[0,0,0,1]]",
        '{"eye": [0.5,0,0.3]}',
    ):
        yield ("trajectory", "T_world_camera"), raw, EITHER if "[0,0,1]" in raw else REFUSED
    for raw in (
        '"missing.txt"',
        "5",
        "[]",
        "{}",
        '{"turntable": 5}',
        '{"frames": 3}',
        '"../outside/poses.txt"',
        '"/dev/zero"',
        '"/etc/passwd"',
    ):
        yield ("trajectory",), raw, REFUSED if raw not in ("{}", '{"frames": 3}') else EITHER
    for raw in (
        '"missing.json"',
        '"no-such-preset"',
        '{"width": 160}',
        "5",
        "[]",
        '"/etc/passwd"',
        '"../outside/camera.json"',
        '"/dev/zero"',
        '""',
    ):
        yield ("camera",), raw, REFUSED
    for raw in ("-1", "NaN", '"much"', "1e300"):
        yield ("poses", "sigma_m"), raw, REFUSED
        yield ("ambient_lux",), raw, REFUSED
    for raw in ('"guessed"', "5", "[]"):
        yield ("poses", "source"), raw, REFUSED
    for raw in (
        '{"slip_frame": -5, "slip_deg": 2}',
        '{"uneven_sd_deg": NaN}',
        '{"uneven_sd_deg": -1}',
        '{"slip_frame": 1e300}',
        "5",
        '{"wobble_deg": 1e300}',
    ):
        yield (*table, "errors"), raw, EITHER if "slip_frame" in raw else REFUSED


def parts() -> Iterator[tuple[str, Expected]]:
    """The list of further surfaces."""
    for raw in (
        "5",
        '"lump.ply"',
        "[5]",
        "[[]]",
        '[{"box": 5}]',
        '[{"box": [[0,0,0]]}]',
        '[{"box": [[0,0,0],[NaN,1,1]]}]',
        '[{"box": [[0,0,0],[0,0,0]]}]',
        '[{"mesh": "lump.ply", "scale": 0}]',
        '[{"mesh": "lump.ply", "scale": NaN}]',
        '[{"mesh": "lump.ply", "scale": -1}]',
        '[{"mesh": "lump.ply", "scale": 1e300}]',
        '[{"mesh": "/etc/passwd"}]',
        '[{"mesh": "../outside/mesh.ply"}]',
        '[{"mesh": "/dev/zero"}]',
        '[{"mesh": "lump.ply", "color": [300, -1, 0]}]',
        '[{"mesh": "lump.ply", "color": 5}]',
        '[{"mesh": "lump.ply", "turns": "maybe"}]',
        '[{"mesh": "lump.ply", "pose": [0,0,0]}]',
        '[{"board": "missing.json"}]',
        '[{"board": "/etc/passwd"}]',
        '[{"board": {"columns": -1, "rows": 5, "square_m": 0.03}}]',
        '[{"board": {"columns": 1000000, "rows": 1000000, "square_m": 0.03}}]',
        '[{"board": {"columns": 7, "rows": 5, "square_m": NaN}}]',
        '[{"mesh": "lump.ply", "reflectance": 7}]',
        '["missing.ply"]',
        "[{}]",
        '[{"mesh": "lump.ply", "box": [[0,0,0],[1,1,1]]}]',
        '[{"box": [[-1e300,-1e300,-1e300],[1e300,1e300,1e300]]}]',
    ):
        yield (
            raw,
            EITHER
            if raw in ('"lump.ply"', '[{"box": [[0,0,0],[0,0,0]]}]', '[{"mesh": "lump.ply", "box": [[0,0,0],[1,1,1]]}]')
            else REFUSED,
        )


def to_simulate() -> Iterator[Case]:
    good = bases.scene()
    for name, content, expected in texts(good):
        yield from _scene(name, content, expected, name == "BOM")
    for path, raw, expected in values():
        yield from _scene(
            f"{path[-1]} {raw[:60]}",
            with_raw(good, path, raw),
            expected,
            (path[-1], raw) in (("reflectance", "NaN"), ("degrees_per_frame", "NaN")),
        )
    for raw, expected in parts():
        yield from _scene(f"parts {raw[:70]}", with_raw(good, ("parts",), raw), expected, False)
    for name, raw in _reaching().items():
        yield from _scene(f"mesh {name}", with_raw(good, ("mesh",), raw), REFUSED, name == "/etc/passwd")
    for name, raw in {
        "missing": '"missing.csv"',
        "/etc/passwd": '"/etc/passwd"',
        "outside": '"../outside/telemetry.csv"',
        "a list": "[1]",
    }.items():
        yield from _scene(f"telemetry {name}", with_raw(good, ("telemetry",), raw), REFUSED, False)
    yield from _scene("name with escape codes", json.dumps(good | {"name": LETTERS}).encode(), EITHER, True)
    yield from _scene("name of 5 kB", json.dumps(good | {"name": "x" * 5000}).encode(), EITHER, False)
    yield from _scene("unknown key with escape codes", json.dumps(good | {LETTERS: 5}).encode(), EITHER, False)
    yield from _scene("unknown key of 5 kB", json.dumps(good | {"x" * 5000: 5}).encode(), EITHER, False)
    for name, put in NO_FILE.items():
        yield from over_file("scene is", f"{name} scene.json", put, RUN, expected=REFUSED)


def _scene(name: str, content: bytes, expected: Expected, quick: bool) -> Iterator[Case]:
    """A scene file in a folder of its own, the mesh beside it, things outside."""

    def make(folder: Path) -> list[str]:
        from broken.crossing import outside

        outside(folder)
        (folder / "in").mkdir()
        bases.lump(folder / "in" / "lump.ply")
        (folder / "in" / "scene.json").write_bytes(content)
        return ["simulate", "in/scene.json", "-o", "out"]

    where = ("scene.json", "lump.ply", "missing", "passwd", "outside", "/dev/zero", "in/", "in in;")
    yield Case(f"scene: {name}: simulate", make, expected, where, quick=quick, weight=2)


def _reaching() -> dict[str, str]:
    return {
        "/etc/passwd": '"/etc/passwd"',
        "outside": '"../outside/mesh.ply"',
        "a good one outside": '"../outside/good_scene.ply"',
        "over the output's camera": '"../outside/camera.json"',
        "/dev/zero": '"/dev/zero"',
        "missing": '"missing.ply"',
        "empty": '""',
        "a dot": '"."',
        "NUL": '"a\\u0000.ply"',
        "5 kB": json.dumps("x" * 5000),
        "escape codes": json.dumps(LETTERS + ".ply"),
        "a number": "5",
        "null": "null",
        "the scene itself": '"scene.json"',
        "a lone surrogate": '"\\ud800.ply"',
        "a web address": '"http://127.0.0.1:9/mesh.ply"',
    }


def of_recordings() -> Iterator[Break]:
    """What a recording's scene.json may say."""
    good = json.loads((bases.place() / "wall" / "scene.json").read_text(encoding="utf-8"))
    where = ("scene.json", "passwd", "outside", "mesh", "rec", "scene.ply")

    def told(content: bytes) -> object:
        return lambda rec: (rec / "scene.json").write_bytes(content)

    for name, raw in _reaching().items():
        sure = (
            ("explain", "simulate", "convert")
            if name in ("/etc/passwd", "outside", "a good one outside", "over the output's camera", "/dev/zero")
            else ("explain", "simulate")
        )
        yield Break(
            f"mesh {name}",
            told(with_raw(good, ("mesh",), raw)),
            REFUSED if name != "null" else EITHER,
            where,
            sure,
            quick=name == "outside",
        )  # type: ignore[arg-type]
    for name, content in whole(good):
        yield Break(
            name, told(content), REFUSED if name != "an empty object" else EITHER, where, ("explain", "simulate")
        )  # type: ignore[arg-type]
    for path, raw in [
        (("reflectance",), "NaN"),
        (("reflectance",), "7"),
        (("reflectance",), '"grey"'),
        (("poses", "sigma_m"), "NaN"),
        (("poses", "sigma_m"), "-1"),
        (("poses", "source"), '"guessed"'),
        (("poses",), "5"),
        (("ambient_lux",), "NaN"),
        (("poses", "sigma_rad"), "1e999"),
        (("poses", "sigma_m"), "9" * 400),
    ]:
        yield Break(
            f"{path[-1]} {raw[:20]}", told(with_raw(good, path, raw)), REFUSED, where, ("explain",), quick=raw == "NaN"
        )  # type: ignore[arg-type]
    for name, put in NO_FILE.items():
        if name != "no file":
            yield Break(
                f"is {name}", lambda rec, put=put: put(rec / "scene.json"), REFUSED, where, ("explain", "simulate")
            )  # type: ignore[misc]
    for name, put in {
        "a FIFO": fifo,
        "a folder": folder,
        "a link to /dev/zero": link("/dev/zero"),
        "a link out": link("../outside/good_scene.ply"),
        "a link to /etc/passwd": link("/etc/passwd"),
        "cut": _cut,
    }.items():
        yield Break(
            f"its mesh is {name}",
            lambda rec, put=put: put(rec / "scene.ply"),
            REFUSED,
            where,
            ("explain", "simulate", "convert") if name != "cut" else ("explain", "simulate"),
        )  # type: ignore[misc]
    yield Break("a name with escape codes", told(json.dumps(good | {"name": LETTERS}).encode()), EITHER, where)  # type: ignore[arg-type]


def _cut(path: Path) -> None:
    path.write_bytes(meshes.ply_binary(meshes.cube())[:-10])


def cases() -> Iterator[Case]:
    yield from to_simulate()
    yield from crossed("recording's scene", of_recordings(), READERS)
