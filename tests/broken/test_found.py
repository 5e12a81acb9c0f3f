"""What fuzzing found once is read or refused for good: each file of found/READER goes through that reader."""

import warnings
from pathlib import Path

import pytest
from broken.readers import readers

from fusion import FusionError

FOUND = sorted(
    path for path in (Path(__file__).parent / "found").glob("*/*") if path.is_file() and path.suffix != ".md"
)


@pytest.mark.parametrize("path", FOUND, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_a_finding_stays_mended(path, good_inputs, tmp_path, capfd):
    reader = next(it for it in readers() if it.name.replace("/", "-").replace(" ", "_") == path.parent.name)
    reader.prepare(tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            reader.read(tmp_path, path.read_bytes())
        except FusionError as error:
            assert "\n" not in str(error)
    printed = capfd.readouterr()
    assert not printed.out + printed.err
