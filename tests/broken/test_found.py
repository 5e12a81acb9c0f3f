"""What fuzzing found once is read or refused for good: each file of found/READER goes through that reader."""

import warnings
from pathlib import Path

import pytest

from broken.open import OPEN
from broken.readers import readers
from fusion import FusionError

FOUND = sorted(
    path for path in (Path(__file__).parent / "found").glob("*/*") if path.is_file() and path.suffix != ".md"
)


# what a library prints about them where fusion is used as one, which docs/security.md does not promise to silence
PRINTED = {
    # the sums are right, so only who unpacks the pixels sees it: doing so twice would cost a third of reading
    "found: depth_image_with_right_sums/half_the_rows": "libpng error: Not enough image data\n",
}


def _named(path: Path) -> str:
    return f"found: {path.parent.name}/{path.name}"


def _open(path: Path) -> list[pytest.MarkDecorator]:
    return [pytest.mark.xfail(strict=True, reason=OPEN[_named(path)])] if _named(path) in OPEN else []


@pytest.mark.parametrize("path", [pytest.param(path, id=_named(path), marks=_open(path)) for path in FOUND])
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
    assert printed.out + printed.err == PRINTED.get(_named(path), "")
