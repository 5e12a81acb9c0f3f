"""Arrays in files of NumPy: numbers, or one line; a header's claim takes no memory."""

import io
import zipfile

import numpy as np
import pytest

from fusion.errors import FusionError
from fusion.files.npy import read_npy


def header(shape: str, kind: str = "<f8") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


def packed() -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("a.npy", b"x")
    return out.getvalue()


BROKEN = [
    (b"", "no .npy file"),
    (b"PK\x03\x04 begins like a zip", "no .npy file"),
    (packed(), "no .npy file"),
    (header("(10**9,)"), "no .npy file"),
    (header("(1000000000000,)"), "too large"),
    (header("(100000000,)"), "cut short"),
    (header("(-1,)"), "no .npy file"),
    (header("(2,)", "|O") + b"12345678" * 2, "holds no numbers"),
    (header("(2,)", "<U4") + b"12345678" * 4, "holds no numbers"),
    (header("(" * 200 + ")" * 200), "no .npy file"),
]


@pytest.mark.parametrize(("data", "said"), BROKEN, ids=[f"{number} {said}" for number, (_, said) in enumerate(BROKEN)])
def test_what_is_no_array_is_told_in_one_line(tmp_path, data, said):
    (tmp_path / "a.npy").write_bytes(data)
    with pytest.raises(FusionError, match=said) as caught:
        read_npy(tmp_path / "a.npy")
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "array", [np.arange(6.0).reshape(2, 3), np.arange(6, dtype=">i2"), np.asfortranarray(np.eye(3))]
)
def test_arrays_are_read_as_they_were_saved(tmp_path, array):
    np.save(tmp_path / "a.npy", array)
    found = read_npy(tmp_path / "a.npy")
    assert found.dtype == np.float64 and np.array_equal(found, array)
