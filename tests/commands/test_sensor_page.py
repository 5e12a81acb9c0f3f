"""`fusion sensor check` and `fusion sensor page`."""

import json

import pytest

from fusion.commands.main import main

COMPLETE = {
    "format": "fusion-sensor/1",
    "name": "mine",
    "sensor": "A camera of mine",
    "serial": "7",
    "principle": "itof",
    "effects": [],
}


@pytest.fixture
def file(tmp_path):
    """Writes a model, with changes."""

    def write(**changes):
        path = tmp_path / "sensor.json"
        path.write_text(json.dumps(COMPLETE | changes))
        return str(path)

    return write


def check(path, capsys) -> tuple[int, list[str]]:
    status = main(["sensor", "check", path, "--json"]) or 0
    return status, json.loads(capsys.readouterr().out)["missing"]


def test_a_complete_model_passes(file, capsys):
    status, missing = check(file(effects=[with_std(0.0001)]), capsys)
    assert (status, missing) == (0, [])


def with_std(std, source="twenty walls"):
    known = {} if std is None else {"std": std}
    rows = {name: {"value": 0.001, "unit": unit} | known for name, unit in (("c0", "m"), ("c1", "1"), ("c2", "1/m"))}
    return {"effect": "axial_noise", "parameters": rows, "source": source}


@pytest.mark.parametrize(
    "changes, said",
    [
        ({"sensor": ""}, "which camera"),
        ({"principle": "unknown"}, "how the camera measures"),
        ({"effects": []}, "an ideal sensor"),
        ({"effects": [with_std(None)]}, "axial_noise.c0: nothing says how well"),
        ({"effects": [with_std(0.1, source="")]}, "no source"),
        ({"effects": [with_std(0.1, source="guess")]}, "a guess"),
    ],
)
def test_what_is_missing_is_said(file, capsys, changes, said):
    status, missing = check(file(**{"effects": [with_std(0.0001)], **changes}), capsys)
    assert status == 1 and any(said in text for text in missing)


def test_a_page_with_its_picture(file, tmp_path, capsys):
    assert not main(["sensor", "page", file(effects=[with_std(None)]), "-o", str(tmp_path / "out"), "--json"])
    told = json.loads(capsys.readouterr().out)
    page = (tmp_path / "out" / "mine.md").read_text()
    assert told["page"].endswith("mine.md") and "<svg" in (tmp_path / "out" / "mine.svg").read_text()
    assert "# A camera of mine" in page and "| 1 | " in page and "not stated" in page and "What is not known" in page


def test_without_a_folder_one_line(file, capsys):
    assert main(["sensor", "page", file()]) == 1
    assert "no folder for the page" in capsys.readouterr().err
