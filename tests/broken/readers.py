"""Every public reader, as a function of the bytes of one file: what properties and the fuzzer call."""

import json
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from broken import bases, foreign, meshes
from broken.inputs import phones, recorded
from broken.inputs.foreign import FORMATS
from broken.pictures import with_right_sums


@dataclass(frozen=True)
class Reader:
    """`read` puts bytes where they belong in a folder that `prepare` made, and reads; it takes `good`."""

    name: str
    good: bytes
    prepare: Callable[[Path], object]
    read: Callable[[Path, bytes], object]


def readers() -> Iterator[Reader]:
    """All of them; the good inputs must have been made: see `bases.prepare`."""
    for name, write in meshes.GOOD.items():
        yield Reader(
            name,
            write(meshes.cube()),
            lambda folder: None,
            _mesh(name.replace("ascii.", "a.").replace("binary.", "b.")),
        )
    import fusion

    scene = json.dumps(
        bases.scene() | {"parts": [{"box": [[-0.4, -1.0, -0.05], [0.6, 1.0, -0.02]], "turns": False}]}, indent=1
    ).encode()
    yield Reader("camera.json", _text("camera.json"), lambda folder: None, _file("camera.json", fusion.find_camera))
    yield Reader(
        "sensor.json",
        json.dumps(bases.sensor(), indent=1).encode(),
        lambda folder: None,
        _file("sensor.json", fusion.read_sensor),
    )
    yield Reader(
        "board.json", json.dumps(bases.BOARD).encode(), lambda folder: None, _file("board.json", fusion.read_board)
    )
    yield Reader("scene.json", scene, lambda folder: bases.lump(folder / "lump.ply"), _file("scene.json", _scene))
    told = json.dumps({"source": "kinect-v1", "serial": "A1", "settings": {"gain": "16"}, "tables": {}}).encode()
    yield Reader("recording's device.json", told, _copied, _recording("device.json"))
    for name in ("depth.txt", "groundtruth.txt", "telemetry.csv", "scene.json", "camera.json", "depth/000000.png"):
        yield Reader(f"recording's {name}", _text(name), _copied, _recording(name))
    image = _recording("depth/000000.png")
    yield Reader(
        "depth image with right sums",
        _text("depth/000000.png"),
        _copied,
        lambda folder, content: image(folder, with_right_sums(content)),
    )
    yield from _foreign()
    yield from _bags()


def _bags() -> Iterator[Reader]:
    """Recordings that are one file: the makers' samples, those written from layouts, archives of phones, MCAP."""
    from fusion.recording.formats.bags.write import write_mcap
    from fusion.recording.open import open_recording

    for name, content, more in [*recorded.good(), *phones.good_archives()]:
        size = bases.CAMERA | recorded.SIZES.get(Path(name).suffix, {})
        camera = "camera.json" if more else None

        def prepare(folder: Path, size: dict = size) -> None:
            bases.write_json(folder / "camera.json", size)

        def read(folder: Path, content: bytes, camera: str | None = camera) -> None:
            (folder / "rec").write_bytes(content)
            walk(folder / "rec", folder / camera if camera else None)

        yield Reader(name, content, prepare, read)
    with tempfile.TemporaryDirectory() as folder:
        bases.recording(Path(folder))
        write_mcap(Path(folder) / "rec.mcap", open_recording(Path(folder) / "rec"))
        content = (Path(folder) / "rec.mcap").read_bytes()
    yield Reader("rec.mcap", content, lambda folder: None, _file("rec", walk))


def _text(name: str) -> bytes:
    return (bases.place() / "wall" / name).read_bytes()


def _copied(folder: Path) -> None:
    bases.recording(folder)


def _mesh(name: str) -> Callable[[Path, bytes], object]:
    import fusion

    return _file(name, lambda path: fusion.read_mesh(path, []))


def _scene(path: Path) -> object:
    import fusion

    return fusion.read_scene(path, [])


def _file(name: str, read: Callable[[Path], object]) -> Callable[[Path, bytes], object]:
    def put(folder: Path, content: bytes) -> object:
        (folder / name).write_bytes(content)
        return read(folder / name)

    return put


def _recording(name: str, camera: str | None = None) -> Callable[[Path, bytes], object]:
    """Opened, every frame asked for, and looked at."""

    def put(folder: Path, content: bytes) -> object:
        (folder / "rec" / name).write_bytes(content)
        return walk(folder / "rec", folder / camera if camera else None)

    return put


def walk(rec: Path, camera: Path | None = None) -> None:
    """Open a recording and ask for some of its frames; a frame may be refused, as the recording may."""
    import fusion

    recording = fusion.open_recording(rec, camera)
    for n in range(min(len(recording), 3)):
        try:
            recording[n]
        except fusion.FusionError:
            continue
    repr(recording)


def _foreign() -> Iterator[Reader]:
    for kind, name in (
        ("7-Scenes", "frame-000001.pose.txt"),
        ("BOP", "scene_camera.json"),
        ("fakenect", "INDEX.txt"),
        ("Open3D", "intrinsic.json"),
        ("nerfstudio", "transforms.json"),
        ("Stray Scanner", "odometry.csv"),
    ):
        build, more = FORMATS[kind]

        def prepare(folder: Path, build: Callable[[Path], object] = build) -> None:
            build(folder / "rec")
            bases.write_json(folder / "camera.json", bases.CAMERA)

        good = {
            "7-Scenes": foreign.UNIT.encode(),
            "BOP": json.dumps(foreign.bop_cameras()).encode(),
            "Open3D": json.dumps(foreign.intrinsic()).encode(),
            "nerfstudio": json.dumps(foreign.transforms()).encode(),
            "Stray Scanner": foreign.odometry().encode(),
            "fakenect": "\n".join(f"d-{1306361010 + n}.25-{3408212745 + 2000000 * n}.pgm" for n in range(3)).encode(),
        }[kind]
        yield Reader(f"{kind} {name}", good, prepare, _recording(name, "camera.json" if more else None))
