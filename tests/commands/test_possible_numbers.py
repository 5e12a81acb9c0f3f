"""Every number is checked for being finite and possible before any work, in commands and in Python alike."""

import pytest

from fusion.commands.main import main
from fusion.errors import FusionError
from fusion.quantity import STEP, VOXEL
from fusion.reconstruction.settings import ReconstructSettings
from fusion.scan.settings import ScanSettings

SCAN = ["turntable", "no-such-recording", "-o", "out"]
TRACK = ["reconstruct", "no-such-recording", "-o", "out"]
WALL = ["calibrate", "depth", "no-such-recording", "-o", "out"]
BOARD = ["calibrate", "intrinsics", "no-such-recording", "--board", "no-such-file", "-o", "out"]
COMPARE = ["compare", "no-such.ply", "no-such.stl", "-o", "out"]
PRINT = ["convert", "no-such.ply", "out.stl"]
REPEAT = ["repeat", "no-such.ply", "no-such.stl", "-o", "out"]
BENCH = ["evaluate", "no-such-recording", "-o", "out"]
SIMULATE = ["simulate", "wall", "-o", "out"]


@pytest.mark.parametrize(
    ("command", "option", "values"),
    [
        *((c, "--voxel", ("0", "-0.001", "nan", "inf", "2", "0.00005")) for c in (SCAN, TRACK)),
        *((c, "--truncation", ("0", "-0.01", "nan", "inf", "20")) for c in (SCAN, TRACK)),
        *((c, "--box", ("nan 0 0 1 1 1", "0 0 0 1 1 inf", "0 0 0 1 1 1e9")) for c in (SCAN, TRACK)),
        (SCAN, "--step", ("0", "nan", "inf", "-400", "1e-9")),
        (TRACK, "--max-depth", ("0", "-1", "nan", "inf")),
        (WALL, "--distance-std", ("-0.1", "nan", "inf")),
        (WALL, "--radial-limit", ("0", "nan", "-3")),
        (BENCH, "--distance-std", ("-0.1", "nan", "inf")),
        (SIMULATE, "--seed", ("-1", "9" * 400)),
        (BOARD, "--distance", ("0", "nan", "inf", "-1")),
        (COMPARE, "--max-distance", ("0", "nan", "inf", "-1")),
        (PRINT, "--triangles", ("0", "-5", "99")),
        (PRINT, "--smooth", ("-1", "5000")),
        ([*PRINT, "--watertight"], "--thin", ("0", "nan", "inf", "-1")),
        (REPEAT, "--diameter", ("0", "nan", "inf", "-1")),
        (REPEAT, "--spacing", ("0", "nan", "inf", "-1")),
        (["demo", "-o", "out"], "--frames", ("0", "-5", "11", "1000000000")),
        (["demo", "-o", "out"], "--seed", ("-1",)),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_not_possible_is_one_line_that_says_what_is(command, option, values, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for value in values:
        assert main([*command, option, *value.split()]) == 1
        told = capsys.readouterr().err
        assert told.count("\n") == 1
        # of the number, not of the recording that is not there: it is asked first
        assert f"is not possible; in {option}; found " in told
        assert "expected " in told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("shell", ["x" * 5000, "\x1b[31mred\x07"], ids=["long", "escapes"])
def test_wrong_usage_is_short_and_shown_as_it_is(shell, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["completion", shell])
    told = capsys.readouterr().err
    assert stop.value.code == 2 and len(told) < 700 and told.endswith("--help tells all\n")
    assert "\x1b" not in told and "\x07" not in told


@pytest.mark.parametrize("command", [SCAN, TRACK])
def test_what_is_no_number_is_wrong_usage(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([*command, "--voxel", "two"])
    assert stop.value.code == 2
    assert "argument --voxel: invalid number value: 'two'" in capsys.readouterr().err


@pytest.mark.parametrize("settings", [ScanSettings, ReconstructSettings])
@pytest.mark.parametrize(
    "wrong",
    [
        {"voxel": 0.0},
        {"voxel": float("nan")},
        {"truncation": 0.0},
        {"voxel": 0.01, "truncation": 0.001},
        {"voxel": 0.001, "truncation": 0.1},
        {"box": ((0, 0, 0), (1, 1, float("nan")))},
        {"box": ((0, 0, 0), (-1, 1, 1))},
        {"box": ((0, 0, 0), (0, 1, 1))},
    ],
    ids=str,
)
def test_settings_hold_only_what_is_possible(settings, wrong):
    with pytest.raises(FusionError):
        settings(**wrong)


@pytest.mark.parametrize("wrong", [{"step": 0.0}, {"step": -7.0}, {"fill_holes": -1.0}, {"strength": "none"}], ids=str)
def test_scan_settings_hold_only_what_is_possible(wrong):
    with pytest.raises(FusionError):
        ScanSettings(**wrong)


def test_what_is_possible_is_taken():
    assert VOXEL.check(None) is None
    assert [VOXEL.check(value) for value in (1e-4, 0.002, 0.1)] == [1e-4, 0.002, 0.1]
    assert [STEP.check(value) for value in (-5.0, 180.0)] == [-5.0, 180.0]
    ScanSettings(box=((-1, -1, 0.5), (1, 1, 2)), step=-0.1, voxel=0.002, truncation=0.008)
