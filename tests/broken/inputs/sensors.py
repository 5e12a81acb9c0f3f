"""sensor.json: the file of a sensor model and the arrays beside it."""

import io
import json
import pickle
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from broken import bases
from broken.case import ACCEPTED, EITHER, REFUSED, Case, Expected
from broken.crossing import over_file
from broken.odd_files import NO_FILE, encodings, fifo, folder, link
from broken.odd_values import LETTERS, NUMBERS, twice, whole, with_raw

SHOW = {"show": ["sensor", "show", "FILE"]}
OTHERS = {
    "simulate": ["simulate", "wall", "--set", "frames=1", "--sensor", "FILE", "--camera", "camera.json", "-o", "out"],
    "json": ["sensor", "show", "FILE", "--json"],
    "reconstruct": ["reconstruct", "wall", "--sensor", "FILE", "-o", "out", "--no-report", "--voxel", "0.02"],
    "explain": ["explain", "wall", "--sensor", "FILE", "-o", "out"],
    "evaluate": ["evaluate", "wall", "--sensor", "FILE", "-o", "out", "--no-report"],
}


class Owned:
    """What a pickle may run."""

    def __reduce__(self) -> tuple:
        return (open, ("owned", "w"))


def simple(**parameters: object) -> dict:
    """A model of one effect, a depth offset unless parameters say another."""
    return {
        "format": "fusion-sensor/1",
        "name": "test",
        "principle": "structured_light",
        "effects": [
            {
                "effect": "depth_offset",
                "parameters": parameters or {"offset": {"value": 0.01, "unit": "m", "std": 0.001}},
                "source": "a test",
            }
        ],
    }


def texts() -> Iterator[tuple[str, bytes, Expected]]:
    """The whole file."""
    good = bases.sensor()
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
    yield "simple", json.dumps(simple()).encode(), ACCEPTED
    yield "name twice", twice(good, "name", '"other"'), EITHER
    yield "a camera.json", json.dumps(bases.CAMERA).encode(), REFUSED


def fields() -> Iterator[tuple[str, bytes, Expected]]:
    """One part is wrong."""
    good = simple()
    value = ("effects", 0, "parameters", "offset", "value")
    for name, raw in NUMBERS.items():
        yield f"value {name}", with_raw(good, value, raw), REFUSED if name not in ("a list", "minus 1e300") else EITHER
    for name, raw in NUMBERS.items():
        if name not in ("null", "a number as text"):
            yield f"std {name}", with_raw(good, (*value[:-1], "std"), raw), REFUSED
    for path, raw in {
        ("format",): '"fusion-sensor/99"',
        ("principle",): '"sonar"',
        ("effects",): "{}",
        ("effects", 0): "5",
        ("effects", 0, "effect"): '"magic"',
        ("effects", 0, "parameters"): "[1]",
        (*value[:-1], "unit"): '"furlong"',
        (*value[:-1], "std"): "-1",
        ("name",): "{}",
        ("effects", 0, "source"): "5",
    }.items():
        yield f"{path[-1]} {raw}", with_raw(good, path, raw), REFUSED if path[-1] not in ("name", "source") else EITHER
    yield "unknown parameter", json.dumps(simple(magic={"value": 1, "unit": "m"})).encode(), REFUSED
    yield "parameter as a bare number", json.dumps(simple(offset=0.01)).encode(), EITHER
    yield "no effects", with_raw(good, ("effects",), "[]"), EITHER
    yield "an effect twice", json.dumps(good | {"effects": good["effects"] * 2}).encode(), EITHER
    yield (
        "effect with escape codes",
        json.dumps(good | {"effects": [{"effect": LETTERS, "parameters": {}}]}).encode(),
        REFUSED,
    )
    yield "effect of 5 kB", json.dumps(good | {"effects": [{"effect": "x" * 5000, "parameters": {}}]}).encode(), REFUSED
    yield "name with escape codes", json.dumps(good | {"name": LETTERS, "sensor": LETTERS}).encode(), EITHER
    yield "unit of 5 kB", with_raw(good, (*value[:-1], "unit"), json.dumps("m" * 5000)), REFUSED
    yield "100,000 effects", json.dumps(good | {"effects": good["effects"] * 100_000}).encode(), EITHER
    harmonics = {
        "effect": "cyclic_error",
        "parameters": {
            "amplitude": {"value": [0.001, 0.002], "unit": "m"},
            "period": {"value": [1.0], "unit": "m"},
            "phase": {"value": [0, 0, 0], "unit": "rad"},
        },
        "source": "a test",
    }
    yield (
        "harmonics of other lengths",
        json.dumps(good | {"principle": "itof", "effects": [harmonics]}).encode(),
        REFUSED,
    )


def arrays() -> Iterator[tuple[str, Callable[[Path], object], Expected]]:
    """A map beside the file that is no array of numbers, or not beside it."""

    def named(content: bytes | Callable[[Path], object], name: str = "map.npy") -> Callable[[Path], object]:
        def put(path: Path) -> None:
            told = {
                "format": "fusion-sensor/1",
                "name": "t",
                "principle": "itof",
                "effects": [
                    {
                        "effect": "fixed_pattern",
                        "parameters": {"rms": {"value": 0.002, "unit": "m"}, "map": {"value": name, "unit": "m"}},
                        "source": "a test",
                    }
                ],
            }
            bases.write_json(path, told)
            if callable(content):
                content(path.parent / "map.npy")
            else:
                (path.parent / "map.npy").write_bytes(content)

        return put

    good = saved(np.zeros((120, 160)))
    files: dict[str, bytes] = {
        "pickle in npy": saved(np.array([Owned()], dtype=object)),
        "bare pickle": pickle.dumps(Owned()),
        "begins like a zip": b"PK\x03\x04" + bytes(60),
        "a zip": zipped(good),
        "empty": b"",
        "text": b"0.1 0.2\n",
        "cut in the header": good[:40],
        "cut in the values": good[:-1000],
        "words": saved(np.array([["a"] * 160] * 120)),
        "complex": saved(np.zeros((120, 160), complex)),
        "structure": saved(np.zeros(120, dtype=[("a", "f4")])),
        "nan": saved(np.full((120, 160), np.nan)),
        "inf": saved(np.full((120, 160), np.inf)),
        "claims 10^18": claim("(1000000000, 1000000000)"),
        "claims 8 GB": claim("(1000000000,)"),
        "claims -1": claim("(-1, 160)"),
        "dates": saved(np.zeros((120, 160), "M8[s]")),
        "header of code": claim("(__import__('os').system('true'),)"),
        "version 9": b"\x93NUMPY\x09\0" + good[8:],
        "header of 4 GB": b"\x93NUMPY\x02\0\xff\xff\xff\xff" + b" " * 1000,
        "deep header": claim("(" * 5000),
    }
    for name, content in files.items():
        yield name, named(content), REFUSED
    for name, put in {
        "a FIFO": fifo,
        "a folder": folder,
        "a link to /dev/zero": link("/dev/zero"),
        "a link out": link("outside/good.npy"),
        "nothing": lambda path: None,
    }.items():
        yield name, named(put), REFUSED
    for name, there in {
        "outside": "../outside/values.npy",
        "/etc/passwd": "/etc/passwd",
        "/dev/zero": "/dev/zero",
        "a folder up": "outside/../../x.npy",
        "NUL": "a\0.npy",
        "5 kB": "x" * 5000 + ".npy",
    }.items():
        yield f"named {name}", named(good, there), REFUSED


def saved(values: np.ndarray) -> bytes:
    """As numpy.save writes it."""
    memory = io.BytesIO()
    np.save(memory, values, allow_pickle=True)
    return memory.getvalue()


def zipped(content: bytes) -> bytes:
    """A zip with one member."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("map.npy", content)
    return memory.getvalue()


def claim(shape: str, kind: str = "<f8") -> bytes:
    """A .npy whose header claims a shape, with few values."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    text += " " * (-(len(text) + 11) % 64) + "\n"
    return b"\x93NUMPY\x01\0" + len(text).to_bytes(2, "little") + text.encode() + bytes(800)


def cases() -> Iterator[Case]:
    here = "sensor.json"
    for name, content, expected in [*texts(), *fields()]:
        quick = name in ("BOM", "value nan", "effect with escape codes")
        yield from (
            case.as_quick() if quick else case
            for case in over_file("sensor", f"{name} {here}", content, SHOW, expected=expected)
        )
        yield from over_file("sensor", f"{name} {here}", content, {"simulate": OTHERS["simulate"]}, expected=expected)
    for name, put, expected in arrays():
        for case in over_file(
            "sensor's array", f"{name} {here}", put, SHOW | {"simulate": OTHERS["simulate"]}, expected=expected
        ):
            yield with_words(
                case,
                ("map.npy", "values.npy", "passwd", "/dev/zero", "x.npy", "a\\x00", "xxx", "broken.json"),
                name in ("pickle in npy", "begins like a zip"),
            )
    for name, put in NO_FILE.items():
        for case in over_file(
            "sensor is", f"{name} {here}", put, SHOW | {"reconstruct": OTHERS["reconstruct"]}, expected=REFUSED
        ):
            yield case.as_quick() if name == "a link to /dev/zero" else case
    for name in ("value nan", "value 400 digits", "unknown parameter", "std -1"):
        content = next(it for called, it, _ in fields() if called == name)
        rest = {key: OTHERS[key] for key in ("json", "reconstruct", "explain", "evaluate")}
        yield from over_file("sensor", f"{name} {here}", content, rest, expected=REFUSED)


def with_words(case: Case, where: tuple[str, ...], quick: bool) -> Case:
    """The same with other words that may say where."""
    from dataclasses import replace

    return replace(case, where=where, quick=quick)
