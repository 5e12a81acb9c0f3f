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
