"""Exit status, one-line errors, help: what every command owes a user who types something wrong."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from fusion import __version__
from fusion.commands.catalogue import COMMANDS
from fusion.commands.main import main
from fusion.errors import RecordingError

# the arguments of each command, with IN for what is read and OUT for what is written
ARGUMENTS = {
    "demo": ["-o", "OUT"],
    "info": ["IN"],
    "record": ["replay:IN", "-o", "OUT"],
    "live": ["replay:IN", "-o", "OUT", "--no-view"],
    "calibrate": ["intrinsics", "IN", "--board", "IN", "-o", "OUT"],
    "convert": ["IN", "OUT"],
    "reconstruct": ["IN", "-o", "OUT"],
    "turntable": ["IN", "-o", "OUT"],
    "merge": ["IN", "IN2", "-o", "OUT"],
    "texture": ["IN", "-o", "OUT"],
    "batch": ["IN", "-o", "OUT", "--", "evaluate", "{rec}", "-o", "{out}"],
    "simulate": ["IN", "-o", "OUT"],
    "sensor": ["show", "IN"],
    "evaluate": ["IN", "-o", "OUT"],
    "explain": ["IN", "--sensor", "kinect-v1", "-o", "OUT"],
    "compare": ["IN", "IN", "-o", "OUT"],
    "doctor": ["--try", "replay:IN"],
    "repeat": ["IN", "IN", "-o", "OUT"],
    "completion": ["bash"],
}
READING = [name for name in COMMANDS if any("IN" in word for word in ARGUMENTS.get(name, ["IN"]))]


def status(arguments: list[str]) -> int:
    """Exit status as a shell sees it; any other exception than argparse's SystemExit fails the test."""
    try:
        return main(arguments)
    except SystemExit as stop:
        return int(stop.code or 0)


def typed(name: str, given: Path | str, out: Path | str) -> list[str]:
    """A command and its arguments, with what is read and what is written."""
    return [name, *(word.replace("IN", str(given)).replace("OUT", str(out)) for word in ARGUMENTS[name])]


def one_line(text: str) -> bool:
    return text.endswith("\n") and text.count("\n") == 1 and "Traceback" not in text


@pytest.fixture
def command(monkeypatch):
    """Makes the command `fusion try` whose `run` is the given function."""

    def make(run) -> None:
        def add_arguments(parser) -> None:
            parser.add_argument("--number", type=int)

        module = SimpleNamespace(EXAMPLE="fusion try --number 3", add_arguments=add_arguments, run=run)
        monkeypatch.setitem(COMMANDS, "try", "nothing, for a test")
        monkeypatch.setitem(sys.modules, "fusion.commands.try", module)

    return make


def raising(error: BaseException):
    def run(options) -> int:
        raise error

    return run


def test_every_command_is_tried_here():
    assert set(ARGUMENTS) == set(COMMANDS)


@pytest.mark.parametrize("result", [None, 0])
def test_success_is_0(command, result):
    command(lambda options: result)
    assert status(["try", "--number", "3"]) == 0


def test_a_problem_with_the_input_is_1_and_one_line(command, capsys):
    command(raising(RecordingError("no depth", "scan/\ndepth.txt", "nothing", "a list\nof files", "record again")))
    assert status(["try"]) == 1
    told = capsys.readouterr().err
    assert one_line(told)
    for part in ["fusion try: ", "no depth", "scan/ depth.txt", "found nothing", "expected a list of files", "again"]:
        assert part in told


@pytest.mark.parametrize(
    "error", [MemoryError(), PermissionError(13, "Permission denied", "out"), OSError(28, "No space left", "out")]
)
def test_what_the_machine_refuses_is_1_and_one_line(command, capsys, error):
    command(raising(error))
    assert status(["try"]) == 1
    assert one_line(capsys.readouterr().err)


def test_interrupted_is_130_as_in_a_shell(command, capsys):
    command(raising(KeyboardInterrupt()))
    assert status(["try"]) == 130
    assert one_line(capsys.readouterr().err)


def test_a_slip_of_the_program_itself_is_one_line_that_says_where(command, capsys):
    command(raising(ZeroDivisionError("by nothing")))
    assert status(["try"]) == 1
    told = capsys.readouterr().err
    assert one_line(told)
    assert "fault of the program itself" in told
    assert "ZeroDivisionError: by nothing" in told
    assert "test_main.py, line" in told
    assert status(["try", "-v"]) == 1
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments", [["no-such-command"], ["--no-such-option"], ["try", "--number", "x"], ["try", "too", "many"]]
)
def test_wrong_usage_is_2(command, capsys, arguments):
    command(lambda options: 0)
    assert status(arguments) == 2
    told = capsys.readouterr().err
    assert "usage: fusion" in told
    assert one_line(told)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        (["turntabel"], "turntable"),
        (["--hlep"], "--help"),
        (["turntable", "rec", "--voxl", "0.001"], "--voxel"),  # though -o is missing too
        (["turntable", "rec", "-o", "out", "--keep-plat=1"], "--keep-plate"),
        (["turntable", "rec", "-o", "out", "--strength", "axsi"], "axis"),
        (["calibrate", "intrinsic"], "intrinsics"),
        (["calibrate", "depth", "rec", "--radial-limt", "3"], "--radial-limit"),
        (["sensor", "shwo"], "show"),
        (["completion", "fsh"], "fish"),
    ],
)
def test_what_is_mistyped_is_answered_with_the_nearest(typed, meant, capsys):
    assert status(typed) == 2
    told = capsys.readouterr().err
    assert one_line(told)
    assert f"did you mean {meant}?" in told


def test_nothing_is_suggested_where_nothing_is_near(capsys):
    assert status(["xyzzy"]) == 2
    assert "did you mean" not in capsys.readouterr().err


def test_options_are_written_out(capsys):
    """What is short for one option today may be short for two tomorrow."""
    assert status(["turntable", "rec", "-o", "out", "--vox", "0.001"]) == 2
    assert "did you mean --voxel?" in capsys.readouterr().err


def test_alone_it_prints_its_help(capsys):
    assert status([]) == 0
    alone = capsys.readouterr().out
    assert status(["--help"]) == 0
    assert capsys.readouterr().out == alone


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_can_be_told_to_say_more_or_less(name, capsys):
    assert status([name, "--help"]) == 0
    told = capsys.readouterr().out
    if name == "calibrate":
        assert status([name, "depth", "--help"]) == 0
        told = capsys.readouterr().out
    for option in ("-v, --verbose", "-q, --quiet"):
        assert option in told
    if "-o" in told:
        assert "--overwrite" in told


@pytest.mark.parametrize("name", COMMANDS)
def test_unknown_options_are_2(name, capsys):
    assert status([name, "--no-such-option"]) == 2
    assert f"usage: fusion {name}" in capsys.readouterr().err


def test_version_and_overview(capsys):
    assert status(["--version"]) == 0
    assert capsys.readouterr().out == f"fusion {__version__}\n"
    assert status(["--help"]) == 0
    told = capsys.readouterr().out
    assert "example: fusion" in told
    for name, text in COMMANDS.items():
        assert f"{name} " in told
        assert text in told


@pytest.mark.parametrize("name", COMMANDS)
def test_help_names_an_example(name, capsys):
    assert status([name, "--help"]) == 0
    assert f"example: fusion {name}" in capsys.readouterr().out


def hostile_inputs(folder: Path) -> dict[str, Path]:
    """Things that are neither a recording nor a mesh."""
    (folder / "empty").mkdir()
    (folder / "nothing.ply").write_bytes(b"")
    (folder / "noise.ply").write_bytes(bytes(range(256)) * 40)
    (folder / "text.obj").write_text("this is no mesh\n")
    (folder / "broken").mkdir()
    (folder / "broken" / "camera.json").write_text('{"width": "NaN", ')
    (folder / "broken" / "depth.txt").write_bytes(b"\xff\xfe 1.0 \x00\n")
    (folder / "dangling").mkdir()
    (folder / "dangling" / "camera.json").write_text(
        '{"width": 4, "height": 4, "fx": 4, "fy": 4, "cx": 1.5, "cy": 1.5, "depth_scale": 1000}'
    )
    (folder / "dangling" / "depth.txt").write_text("1.0 depth/none.png\n2.0 ../../../etc/passwd\n")
    made = ["empty", "nothing.ply", "noise.ply", "text.obj", "broken", "dangling"]
    inputs = {name: folder / name for name in made}
    return {**inputs, "missing": folder / "no such thing", "very long": folder / ("x" * 5000), "no name": Path()}


HOSTILE = ["empty", "nothing.ply", "noise.ply", "text.obj", "broken", "dangling", "missing", "very long", "no name"]


@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("name", READING)
def test_hostile_input_is_1_and_one_line_and_leaves_nothing(name, kind, tmp_path, capsys, monkeypatch):
    inputs, results = tmp_path / "inputs", tmp_path / "results"
    inputs.mkdir()
    results.mkdir()
    monkeypatch.chdir(results)  # "no name" reads an empty folder
    found = status(typed(name, hostile_inputs(inputs)[kind], results / "out"))
    told = capsys.readouterr().err
    if name == "info" and kind == "dangling":
        assert found in (0, 1)  # the doctor may describe a recording whose images are missing
    else:
        assert found == 1
        assert one_line(told), told
    assert "Traceback" not in told
    assert not (results / "out").exists()


@pytest.mark.parametrize("name", [name for name, words in ARGUMENTS.items() if "-o" in words])
def test_an_output_that_is_a_file_is_told_before_any_work(name, tmp_path, capsys):
    (tmp_path / "taken").write_text("mine")
    (tmp_path / "empty").mkdir()
    assert status(typed(name, tmp_path / "empty", tmp_path / "taken")) == 1
    assert one_line(capsys.readouterr().err)
    assert (tmp_path / "taken").read_text() == "mine"


def test_a_reader_that_goes_away_is_no_failure():
    """As in `fusion ... | head -1`."""
    program = """
import sys
from types import SimpleNamespace
from fusion.commands.catalogue import COMMANDS
from fusion.commands.main import main
def run(options):
    for _ in range(100_000):
        print("a line")
COMMANDS["try"] = "nothing"
sys.modules["fusion.commands.try"] = SimpleNamespace(EXAMPLE="", add_arguments=lambda parser: None, run=run)
raise SystemExit(main(["try"]))
"""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=30) == 0
