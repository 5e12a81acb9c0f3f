"""Archives of arrays: what their directory and headers promise is looked at before anything is unpacked."""

import io
import zipfile

import numpy as np
import pytest

from fusion.errors import MeshError, VolumeError
from fusion.files.npy import read_npz
from fusion.mesh.comparison.seen import read_seen
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume


def header(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": kind, "fortran_order": False, "shape": shape})
    return file.getvalue()


def archive(path, **parts: bytes):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in parts.items():
            file.writestr(f"{name}.npy", data)
    return path


def test_zeros_are_not_unpacked_beyond_what_is_allowed(tmp_path, trusting):
    path = archive(tmp_path / "a.npz", points=header((200_000, 3)) + bytes(4_800_000))
    assert path.stat().st_size < 10_000
    trusting(0.001, False)
    with pytest.raises(MeshError, match=r"0.0048 GB.*--allow-gb"):
        read_seen(path)


@pytest.mark.parametrize(
    ("parts", "told"),
    [
        ({"points": header((1 << 40, 3))}, "too large"),
        ({"points": header((5, 3))}, "cut short"),
        ({"points": header((5, 3)) + bytes(5 * 3 * 8 + 1)}, "more than its header"),
        ({"points": header((5, 3), "|O") + bytes(5 * 3 * 8)}, "no numbers"),
        ({"points": header((5, 3), "<U8") + bytes(5 * 3 * 32)}, "numbers"),
        ({"points": header((5,)) + bytes(5 * 8)}, r"an array \(5,\)"),
        ({"points": b"no"}, "no .npy file"),
        ({"a": b"", "b": b""}, "no array points"),
    ],
)
def test_archives_that_do_not_hold_what_they_promise(tmp_path, parts, told):
    with pytest.raises(MeshError, match=told):
        read_seen(archive(tmp_path / "a.npz", **parts))


@pytest.mark.parametrize("name", ["a.npz", "a.npy"])
def test_a_file_that_only_begins_like_one(tmp_path, name):
    for data in (b"PK\3\4" + bytes(50), b"PK\5\6" + bytes(18), b"\x93NUMPY\1\0\xff\xff{", b""):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(MeshError):
            read_seen(tmp_path / name)


def test_the_only_array_may_have_any_name(tmp_path):
    np.savez_compressed(tmp_path / "a.npz", somewhere=np.eye(3, dtype=np.float32))
    np.testing.assert_array_equal(read_seen(tmp_path / "a.npz"), np.eye(3))
    np.save(tmp_path / "b.npy", np.eye(3, order="F"))
    np.testing.assert_array_equal(read_seen(tmp_path / "b.npy"), np.eye(3))


def test_any_mutation_of_a_volume_is_a_volume_or_one_line(tmp_path):
    path, random = tmp_path / "v.npz", np.random.default_rng(3)
    Volume(VolumeSettings(0.01, 0.04, color=True)).save(path)
    good = path.read_bytes()
    for _ in range(60):
        data = bytearray(good)
        for _ in range(random.integers(1, 4)):
            data[random.integers(len(data))] = random.integers(256)
        path.write_bytes(data[: random.integers(len(data))] if random.random() < 0.2 else data)
        try:
            Volume.load(path)
        except VolumeError as error:
            assert "\n" not in str(error)


@pytest.mark.parametrize(
    "change",
    [
        {"voxel": np.nan}, {"coordinates": np.zeros((2, 3), np.int32)}, {"voxels": np.zeros((1, 5, 2), np.float32)},
        {"coordinates": np.full((1, 3), 1 << 25)}, {"bounds": np.zeros((2, 1))}, {"max_bytes": np.array("many")},
    ],
)  # fmt: skip
def test_volumes_that_do_not_fit_together(tmp_path, change):
    Volume(VolumeSettings(0.01, 0.04)).save(tmp_path / "v.npz")
    parts = read_npz(tmp_path / "v.npz")
    np.savez(tmp_path / "v.npz", **(parts | change))
    with pytest.raises(VolumeError):
        Volume.load(tmp_path / "v.npz")
