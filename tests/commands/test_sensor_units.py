"""`fusion sensor units` over a list and over a folder."""

import json

import pytest

from fusion.commands.main import main

MODEL = {"format": "fusion-sensor/1", "principle": "itof"}


@pytest.fixture
def lab(tmp_path):
    """Three units on two dates, each in a folder, and a list of them."""
    lines = ["sensor, unit, date"]
    for unit, offset in (("a", 0.001), ("b", 0.004), ("c", -0.002)):
        for year in (2024, 2026):
            folder = tmp_path / "lab" / f"{unit}_{year}"
            folder.mkdir(parents=True)
            value = {"value": offset + 0.001 * (year - 2024), "unit": "m", "std": 0.0001}
            effect = {"effect": "depth_offset", "parameters": {"offset": value}, "source": "walls"}
            (folder / "sensor.json").write_text(json.dumps(MODEL | {"name": unit, "effects": [effect]}))
            lines.append(f"lab/{unit}_{year}/sensor.json, {unit}, {year}-06-01")
    (tmp_path / "list.csv").write_text("\n".join(lines) + "\n")
    return tmp_path


def test_a_list_with_dates(lab, capsys):
    assert not main(["sensor", "units", str(lab / "list.csv"), "--json", "-o", str(lab / "out")])
    told = json.loads(capsys.readouterr().out)
    assert told["units"] == ["a", "b", "c"] and 0.8e-3 < told["drift"]["value"][0] < 1e-3  # along the ray
    page = (lab / "out" / "report.html").read_text()
    assert json.loads((lab / "out" / "units.json").read_text()) == told and "3 units of one camera" in page
    assert "Over time" in page


def test_a_folder_of_results_without_dates(lab, capsys):
    assert not main(["sensor", "units", str(lab / "lab")])
    said = capsys.readouterr().out
    assert "6 units, 6 models" in said


def test_a_folder_tells_units_by_their_serial_numbers_and_dates_by_its_names(lab, capsys):
    for folder in sorted((lab / "lab").iterdir()):
        model = json.loads((folder / "sensor.json").read_text())
        unit, year = folder.name.split("_")
        (folder / "sensor.json").write_text(json.dumps(model | {"serial": unit}))
        folder.rename(folder.with_name(f"{unit}_{year}-06-01-1f"))
    assert not main(["sensor", "units", str(lab / "lab"), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["units"] == ["a", "b", "c"] and 0.8e-3 < told["drift"]["value"][0] < 1e-3


@pytest.mark.parametrize(
    "text, said",
    [
        ("unit,date\na,2024-01-01\n", "a line names no sensor"),
        ("sensor,date\nlab/a_2024/sensor.json,June\n", "a date cannot be read"),
        ("sensor\nnone.json\n", "none.json"),
        ("sensor\n", "nothing to compare"),
        ("sensor,unit\nlab/a_2024/sensor.json,a\n", "one unit alone has no spread"),
        ("", "nothing to compare"),
        ("\x00\x01\x02", "the list is not text"),
    ],
)
def test_a_list_that_cannot_be_used_is_one_line(lab, capsys, text, said):
    (lab / "list.csv").write_text(text)
    assert main(["sensor", "units", str(lab / "list.csv"), "-o", str(lab / "out")]) == 1
    assert said in capsys.readouterr().err and not (lab / "out").exists()


def camera(unit: int, year: int) -> dict:
    return {
        "width": 640,
        "height": 480,
        "fx": 580.0 + unit + 0.5 * (year - 2024),
        "fy": 580.0,
        "cx": 320.0,
        "cy": 240.0,
    }


def evaluation(unit: int, year: int) -> dict:
    look = {"name": "wall_1m", "bias": {"offset_m": 0.001 * unit + 0.002 * (year - 2024)}, "noise": None}
    look |= {"depth": {"std_robust_m": {"median": 0.001}}, "shares": {"no_data": 0.01 * unit}}
    look |= {"drift": {"change_ten_minutes_m": None}}
    return {"format": "fusion-evaluation/1", "camera": {"serial": f"s{unit}"}, "stretches": [look]}


@pytest.fixture
def results(tmp_path):
    """Folders of three units on two dates with what other commands write, and lists of them."""
    for kind, content in (("camera", camera), ("evaluation", evaluation)):
        lines = ["sensor,unit,date"]
        for unit in range(3):
            for year in (2024, 2026):
                folder = tmp_path / f"{kind}s" / f"{unit}_{year}"
                folder.mkdir(parents=True)
                (folder / f"{kind}.json").write_text(json.dumps(content(unit, year)))
                lines.append(f"{kind}s/{unit}_{year}/{kind}.json,u{unit},{year}-06-01")
        (tmp_path / f"{kind}s.csv").write_text("\n".join(lines) + "\n")
    return tmp_path


@pytest.mark.parametrize(
    ("kind", "label", "apart", "slope"),
    [("camera", "fx [px]", 1.0, 0.5), ("evaluation", "wall_1m: offset [m]", 0.001, 0.002)],
)
def test_other_results_are_compared_by_what_they_state(results, capsys, kind, label, apart, slope):
    assert not main(["sensor", "units", str(results / f"{kind}s.csv"), "--json", "-o", str(results / "out")])
    told = json.loads(capsys.readouterr().out)
    at = told["quantities"].index(label)
    # two years of 365.25 days are 730 days here
    assert told["units"] == ["u0", "u1", "u2"] and told["drift"]["value"][at] == pytest.approx(slope, rel=0.01)
    # variance of the means of the units, less half of what the dates of a unit differ by: 2 (slope)^2
    expected = max(apart**2 - (2 * slope) ** 2 / 4, 0) ** 0.5
    assert told["between"]["value"][at] == pytest.approx(expected, abs=1e-9)
    assert "Units over time" in (results / "out" / "report.html").read_text()
    assert not main(["sensor", "units", str(results / f"{kind}s")])  # a folder of them, without dates
    assert label in capsys.readouterr().out


def test_what_is_not_known_is_no_quantity(results, capsys):
    assert not main(["sensor", "units", str(results / "evaluations.csv"), "--json"])
    labels = json.loads(capsys.readouterr().out)["quantities"]
    assert labels == ["wall_1m: offset [m]", "wall_1m: noise of a pixel [m]", "wall_1m: no data [1]"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sensor\ncameras/0_2024/camera.json\nevaluations/0_2024/evaluation.json\n", "different things"),
        ("sensor,unit\ncameras/0_2024/camera.json,a\n", "one unit alone"),
        ("sensor\nnone/camera.json\n", "none"),
        ("sensor\nother/evaluation.json\n", "no evaluation"),
        ("sensor\nhalf/evaluation.json\n", "an evaluation cannot be used"),
        ("sensor,unit\nevaluations/0_2024/evaluation.json,a\nlone/evaluation.json,b\n", "no quantity in common"),
    ],
)
def test_results_that_cannot_be_compared_are_one_line(results, capsys, text, said):
    for name, content in (
        ("other", {}),
        ("half", {"format": "fusion-evaluation/1"}),
        ("lone", evaluation(1, 2024) | {"stretches": []}),
    ):
        (results / name).mkdir()
        (results / name / "evaluation.json").write_text(json.dumps(content))
    (results / "list.csv").write_text(text)
    assert main(["sensor", "units", str(results / "list.csv"), "-o", str(results / "out")]) == 1
    assert said in capsys.readouterr().err and not (results / "out").exists()
