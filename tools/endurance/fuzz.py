"""Coverage-guided fuzzing of the program's own parsers, by Atheris (libFuzzer): any bytes are read or refused.

pip install -e '.[dev,fuzz]'
python -m tools.endurance.fuzz ply --minutes 10
python -m tools.endurance.fuzz --list

A parser returns or raises a FusionError. Every other exception, every warning, and an input that takes more than 10 s
or 2 GB is a finding: its bytes are kept in tests/broken/found/PARSER, where tests/broken/test_found.py reads them in
every later test. Exit status 0 where nothing was found, 1 otherwise.
"""

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(PROJECT / "tests"), str(PROJECT)]

# names on the command line: names of readers in tests/broken/readers.py
PARSERS = {
    "ply": "ascii.ply",
    "ply-binary": "little.ply",
    "pcd": "ascii.pcd",
    "pcd-binary": "binary.pcd",
    "xyz": "points.xyz",
    "obj": "cube.obj",
    "off": "cube.off",
    "stl": "ascii.stl",
    "stl-binary": "binary.stl",
    "glb": "cube.glb",
    "camera": "camera.json",
    "sensor": "sensor.json",
    "board": "board.json",
    "scene": "scene.json",
    "depth-list": "recording's depth.txt",
    "poses": "recording's groundtruth.txt",
    "telemetry": "recording's telemetry.csv",
    "png": "depth image with right sums",
    "bop": "BOP scene_camera.json",
    "open3d": "Open3D intrinsic.json",
    "fakenect": "fakenect INDEX.txt",
    "7-scenes": "7-Scenes frame-000001.pose.txt",
}
SECONDS, MEGABYTES = 10, 2000


def main() -> int:
    """Fuzz in a process of its own, which libFuzzer ends as it likes; then say what there is."""
    options = _options()
    if options.list:
        print("\n".join(PARSERS))
        return 0
    if options.inside:
        _fuzz(options)
        return 0
    status = 0
    with tempfile.TemporaryDirectory(prefix="fuzz-") as made:
        for name in options.parser or list(PARSERS):
            status |= _guarded(name, options.minutes, Path(made))
    return status


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parser", nargs="*", metavar="PARSER", help="default: all, one after the other")
    parser.add_argument("--minutes", type=float, default=10, help="for each parser")
    parser.add_argument("--list", action="store_true", help="names of the parsers")
    parser.add_argument("--inside", type=Path, help=argparse.SUPPRESS)
    return parser.parse_args()


def found_folder(name: str) -> Path:
    """Where findings of a parser are kept, by the name of its reader."""
    return PROJECT / "tests" / "broken" / "found" / PARSERS[name].replace("/", "-").replace(" ", "_")


def _guarded(name: str, minutes: float, made: Path) -> int:
    """Run the fuzzer again after each end of it, until the time is up; the good inputs in `made` are made once."""
    until = time.monotonic() + 60 * minutes
    before = set(found_folder(name).glob("*"))
    runs, place = 0, made / name
    place.mkdir()
    while (left := until - time.monotonic()) > 1:
        command = [
            sys.executable,
            "-m",
            "tools.endurance.fuzz",
            name,
            "--inside",
            str(place),
            "--minutes",
            str(left / 60),
        ]
        log = place / "log"
        with log.open("wb") as file:
            subprocess.run(command, stdout=file, stderr=file, check=False)
        runs += _runs(log)
        _take_crashes(name, place)
    news = sorted(set(found_folder(name).glob("*")) - before)
    print(f"{name}: {minutes:g} minutes, {runs} inputs, {len(news)} found", *news, sep="\n  ", flush=True)
    return int(bool(news))


def _runs(log: Path) -> int:
    """The number of inputs that libFuzzer says it tried."""
    counts = [
        line.split()[0][1:]
        for line in log.read_text(encoding="utf-8", errors="replace").splitlines()
        if line.startswith("#")
    ]
    return max((int(count) for count in counts if count.isdigit()), default=0)


def _take_crashes(name: str, place: Path) -> None:
    """What libFuzzer itself wrote: inputs that took too long, too much, or ended the process."""
    for path in place.glob("kept/*"):
        _keep(name, path.read_bytes())
        path.unlink()


def _keep(name: str, content: bytes) -> None:
    folder = found_folder(name)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / hashlib.sha256(content).hexdigest()[:16]).write_bytes(content)


def _fuzz(options: argparse.Namespace) -> None:
    import atheris

    with atheris.instrument_imports(include=["fusion"]):
        import fusion

        reader = _reader(options.parser[0], options.inside)
        # readers are loaded where they are first used: now, while imports are instrumented
        reader.read(options.inside / "case", reader.good)
    warnings.simplefilter("error")
    seen: set[str] = set()
    name, folder = options.parser[0], options.inside / "case"

    def one(content: bytes) -> None:
        try:
            reader.read(folder, content)
        except fusion.FusionError:
            pass
        except Exception as error:
            where = "|".join(
                f"{frame.filename}:{frame.lineno}" for frame in traceback.extract_tb(error.__traceback__)[-2:]
            )
            if f"{type(error)} {where}" not in seen:  # one input of each kind is enough
                seen.add(f"{type(error)} {where}")
                _keep(name, content)
                traceback.print_exc()

    for part in ("kept", "seeds"):
        (options.inside / part).mkdir(exist_ok=True)
    (options.inside / "seeds" / "good").write_bytes(reader.good)
    words = _dictionary(options.inside / "words")
    atheris.Setup(
        [
            sys.argv[0],
            f"-max_total_time={max(1, int(options.minutes * 60))}",
            f"-timeout={SECONDS}",
            f"-rss_limit_mb={MEGABYTES}",
            "-max_len=20000",
            f"-dict={words}",
            f"-artifact_prefix={options.inside}/kept/",
            str(options.inside / "seeds"),
        ],
        one,
    )
    atheris.Fuzz()


def _reader(name: str, place: Path):
    from broken import bases
    from broken.readers import readers

    (place / "case").mkdir(exist_ok=True)
    os.environ["MPLBACKEND"] = "Agg"
    bases.prepare(place.parent / "bases")
    reader = next(it for it in readers() if it.name == PARSERS[name])
    if not any((place / "case").iterdir()):
        reader.prepare(place / "case")
    return reader


def _dictionary(path: Path) -> Path:
    """Words that are hard to find by chance."""
    from broken.mutations import EXTREMES, PIECES

    words = [word for word in (*EXTREMES, *PIECES) if 0 < len(word) < 60]
    path.write_text(
        "".join('"' + "".join(f"\\x{byte:02x}" for byte in word) + '"\n' for word in words), encoding="ascii"
    )
    return path


if __name__ == "__main__":
    raise SystemExit(main())
