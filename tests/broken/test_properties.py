"""Every public reader, given any bytes, returns or raises a FusionError: nothing else, no warning, nothing printed."""

import logging
import os
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from broken.mutations import mutated
from broken.readers import Reader, readers
from fusion import FusionError

# the same examples every time: what fails on one machine fails on all; the slow part looks further
QUICK, SLOW = 25, 200
SECONDS = 10.0  # for one small file: an endless or swollen answer, not a slow machine


@pytest.fixture(scope="module")
def all_readers(good_inputs: Path) -> dict[str, Reader]:
    # what readers leave out is logged; a program that sets up no log would see it on stderr
    logging.getLogger("fusion").addHandler(logging.NullHandler())
    return {reader.name: reader for reader in readers()}


NAMES = [
    "ascii.ply",
    "little.ply",
    "big.ply",
    "ascii.pcd",
    "binary.pcd",
    "points.xyz",
    "cube.obj",
    "cube.off",
    "ascii.stl",
    "binary.stl",
    "cube.glb",
    "cube.3mf",
    "camera.json",
    "sensor.json",
    "board.json",
    "scene.json",
    "nerfstudio transforms.json",
    "Stray Scanner odometry.csv",
    "recording's depth.txt",
    "recording's groundtruth.txt",
    "recording's telemetry.csv",
    "recording's scene.json",
    "recording's camera.json",
    "recording's depth/000000.png",
    "depth image with right sums",
    "7-Scenes frame-000001.pose.txt",
    "BOP scene_camera.json",
    "fakenect INDEX.txt",
    "Open3D intrinsic.json",
    "realsense_2_56.bag",
    "realsense_2_59.db3",
    "openni2_dummy.oni",
    "azure.mkv",
    "room.sens",
    "room.klg",
    "room_Depth.dat",
    "plain.xef",
    "archived.xef",
    "phone.r3d",
    "polycam.zip",
    "rec.mcap",
    "recording's device.json",
]


@pytest.fixture
def printed() -> Iterator[Path]:
    """A file that takes what any library prints, by whatever way."""
    with tempfile.NamedTemporaryFile() as file:
        kept = [os.dup(1), os.dup(2)]
        for number in (1, 2):
            os.dup2(file.fileno(), number)
        try:
            yield Path(file.name)
        finally:
            for number, old in zip((1, 2), kept, strict=True):
                os.dup2(old, number)
                os.close(old)


def hold(reader: Reader, folder: Path, printed: Path, examples: int) -> None:
    """The property, for so many examples."""
    folder.mkdir()
    reader.prepare(folder)
    reader.read(folder, reader.good)

    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.explicit, Phase.generate, Phase.shrink),
    )
    @given(mutated(reader.good))
    def one(content: bytes) -> None:
        before, start = _peak(), time.process_time()
        try:
            reader.read(folder, content)
        except FusionError as error:
            text = str(error)
            assert "\n" not in text and len(text) < 1500, f"no line for a person: {text[:200]!r}"
        assert time.process_time() - start < SECONDS
        assert _peak() - before < 1e9, "memory"
        assert printed.stat().st_size == 0, printed.read_bytes()[:300]

    one()


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


@pytest.mark.parametrize("name", NAMES)
def test_any_bytes_are_read_or_refused(name, all_readers, tmp_path, printed):
    hold(all_readers[name], tmp_path / "case", printed, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_many_more_bytes_are_read_or_refused(name, all_readers, tmp_path, printed):
    hold(all_readers[name], tmp_path / "case", printed, SLOW)


def test_every_reader_is_tried(all_readers):
    assert sorted(all_readers) == sorted(NAMES)
