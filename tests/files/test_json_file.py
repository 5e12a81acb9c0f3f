"""JSON from outside: read to one object of finite numbers, or refused in one line that says what and where."""

import json

import pytest

from fusion.errors import FusionError, RecordingError
from fusion.files.json_file import read_json

BROKEN = [
    (b'{"a": 1, "b": {"fx": 1, "fx": 2}}', 'holds a key twice.*"fx" twice'),
    (b'{"a": NaN}', '"a" cannot be used.*found NaN.*finite'),
    (b'{"a": [{"b": 1}, {"b": -Infinity}]}', '"b" of a 2 cannot be used.*finite'),
    (b'{"parts": [{"effect": 1}, {"low": NaN}]}', '"low" of part 2 cannot be used'),
    (b'{"a": 1e999}', "finite number"),
    (b'{"width": ' + b"9" * 400 + b"}", '"width" cannot be used.*finite number'),
    (b'{"a": ' + b"9" * 5000 + b"}", "finite number"),
    (b'{"a": ' + b"[" * 70 + b"]" * 70 + b"}", "nested too deep"),
    (b'{"a": ' + b"[" * 200000, "nested too deep"),
    (b'{"a": ' * 200000, "nested too deep"),
    (b'{"a": 1,\n "b": }', r"not valid JSON.*line 2, column 7"),
    (b"[1]", "holds no JSON object"),
    (b"", "not valid JSON"),
    (b'{"a": "\xff"}', "not text"),
]


@pytest.mark.parametrize(("data", "said"), BROKEN, ids=[said for _, said in BROKEN])
def test_what_is_no_good_json_is_told_in_one_line(tmp_path, data, said):
    path = tmp_path / "x.json"
    path.write_bytes(data)
    with pytest.raises(RecordingError, match=said) as caught:
        read_json(path, RecordingError)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value) and len(str(caught.value)) < 400


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_marks_and_line_ends_change_nothing(tmp_path, encoding, end):
    content = {"name": "Prüfling", "numbers": [1, 2.5, -3e-7], "none": None, "deep": {"a": [True, {}]}}
    text = json.dumps(content, indent=1, ensure_ascii=False).replace("\n", end)
    (tmp_path / "x.json").write_bytes(text.encode(encoding))
    assert read_json(tmp_path / "x.json") == content


def test_tables_of_many_dimensions_and_long_numbers_are_read(tmp_path):
    (tmp_path / "x.json").write_text('{"a": ' + "[" * 40 + "1" + "]" * 40 + ', "b": 123456789012345678901234567890}')
    content = read_json(tmp_path / "x.json")
    assert content["b"] == pytest.approx(1.2345678901234568e29)


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(FusionError, match=r"the board file cannot be read.*gone\.json"):
        read_json(tmp_path / "gone.json", what="the board file")


def test_a_text_whose_values_would_fill_the_memory_is_refused_before(tmp_path, trusting):
    trusting(1e-4, False)  # 100 kB
    (tmp_path / "x.json").write_text('{"a": [' + "{}," * 1000 + "0]}")
    with pytest.raises(FusionError, match=r"with all its values is too large.*--allow-gb"):
        read_json(tmp_path / "x.json")
