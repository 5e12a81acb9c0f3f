"""Sensor files that went through something: each is read, or refused in one clear line, and never more than that."""

import copy
import json
import random

import numpy as np
import pytest

from fusion.errors import SensorError
from fusion.geometry.camera import Camera
from fusion.sensor.catalogue import KNOWN
from fusion.sensor.effects import EFFECTS
from fusion.sensor.files.sensor_file import read_sensor, write_sensor
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor

CAMERA = Camera(8, 6, 10.0, 10.0, 3.5, 2.5)
NASTY = [
    *(
        None,
        True,
        False,
        "",
        "text",
        "NaN",
        "gone.npy",
        "broken.npy",
        "words.npy",
        "complex.npy",
        ".",
        "../..",
        "\0.npy",
    ),
    *(0, -1, 1, 1e-300, 1e300, -1e300, 10**400, float("nan"), float("inf"), float("-inf")),
    *([], {}, [[]], [{}], {"value": None}, {"value": {}}, {"value": []}, {"value": [1, [2]]}, {"value": "\n"}),
    *([1], [0, 0], [1, "2"], [None], [True], [[1, 2], [3]], [float("nan")], [1e300] * 3, ["depth"], ["depth", "u"]),
    [[[[[[[[1]]]]]]]],
    "x" * 5000,
    [0] * 5000,
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("files")
    (place / "broken.npy").write_bytes(b"\x93NUMPY\x01\x00nothing else")
    np.save(place / "words.npy", np.array(["a", "b"]))
    np.save(place / "complex.npy", np.array([1j, 2j]))
    return place


def whole(rng: random.Random) -> dict:
    """A right file with some effects at their typical values."""
    entries = []
    for kind in rng.sample(EFFECTS, 4):
        given = {p.label: {"value": p.typical, "unit": p.unit, "std": 0.1} for p in parameters(kind).values()}
        entries.append({"effect": kind.name, "parameters": given, "source": "s"})
    entries.append({"effect": "tsdf_bias", "parameters": {"truncation": {"value": 0.01, "unit": "m"}}})
    return {"format": "fusion-sensor/1", "name": "n", "principle": "itof", "baseline_m": 0.1, "effects": entries}


def places(node, path=()):
    """Every place of a JSON value, as the keys that lead there."""
    yield path
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, child in children:
        yield from places(child, (*path, key))


def harmed(content: dict, rng: random.Random) -> dict:
    """The content with one value replaced, taken away, or given under another name."""
    content = copy.deepcopy(content)
    *way, last = rng.choice([path for path in places(content) if path])
    parent = content
    for key in way:
        parent = parent[key]
    match rng.randrange(6):
        case 0 if isinstance(parent, dict):
            del parent[last]
        case 1 if isinstance(parent, dict):
            parent[rng.choice(["", "value", "unit", "effect", "name", *KNOWN])] = parent.pop(last)
        case 2 if isinstance(parent, list):
            parent.append(copy.deepcopy(parent[last]))
        case _:
            parent[last] = copy.deepcopy(rng.choice(NASTY))
    return content


def read_or_refuse(path) -> bool:
    """True when the file was read; what is read can be used and written."""
    try:
        sensor = read_sensor(path)
        depth = np.full(CAMERA.shape, 1.0, np.float32)
        sensor.correct(sensor.sample(depth, CAMERA, None, np.random.default_rng(0)), CAMERA)
        write_sensor(path.with_name("again.json"), sensor)
        assert read_sensor(path.with_name("again.json")).effects == sensor.effects
    except SensorError as error:
        text = str(error)
        assert "\n" not in text and len(text) < 3000
        return False
    return True


@pytest.mark.parametrize("seed", range(12))
def test_a_harmed_file_is_read_or_refused_in_one_line(seed, folder):
    rng = random.Random(seed)
    read = []
    for _ in range(60):
        content = whole(rng)
        for _ in range(rng.randint(1, 2)):
            content = harmed(content, rng)
        (folder / "s.json").write_text(json.dumps(content))
        read.append(read_or_refuse(folder / "s.json"))
    assert 0 < sum(read) < len(read)  # some harm does no harm


@pytest.mark.parametrize("seed", range(4))
def test_flipped_bytes_are_read_or_refused_in_one_line(seed, folder):
    rng = random.Random(seed)
    for _ in range(40):
        data = bytearray(json.dumps(whole(rng)).encode())
        for _ in range(rng.randint(1, 4)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        (folder / "s.json").write_bytes(bytes(data[: rng.randrange(len(data))] if rng.random() < 0.2 else data))
        read_or_refuse(folder / "s.json")


@pytest.mark.parametrize("value", NASTY, ids=lambda value: repr(value)[:30].encode("ascii", "replace").decode())
@pytest.mark.parametrize("where", ["value", "std", "unit"])
def test_each_nasty_value_at_each_place(value, where, folder):
    for name in ("depth_offset", "vertical_banding", "tabulated", "voxelization"):
        for key in KNOWN[name]:
            entry = {"value": 0.01} | {where: value}
            content = {"format": "fusion-sensor/1", "effects": [{"effect": name, "parameters": {key: entry}}]}
            (folder / "s.json").write_text(json.dumps(content))
            read_or_refuse(folder / "s.json")


def test_a_key_that_stands_twice_is_refused(tmp_path):
    path = tmp_path / "s.json"
    path.write_text('{"format": "fusion-sensor/1", "effects": [], "name": "a", "name": "b"}')
    with pytest.raises(SensorError, match='"name" twice'):
        read_sensor(path)


def test_a_sensor_without_anything_survives(tmp_path):
    write_sensor(tmp_path / "s.json", Sensor())
    assert read_sensor(tmp_path / "s.json") == Sensor()
