"""Only the program's own lines reach the terminal, and nothing in them moves its cursor."""

import json
import os
import subprocess
import sys

import pytest

from fusion.commands.main import main
from fusion.errors import LONGEST, FusionError, printable
from fusion.files import inside, limits

NOISY = """
import os, sys, warnings, logging
from fusion.commands.terminal.own_lines import show_own_lines
show_own_lines({verbose})
os.write(1, b"library on 1\\n"); os.write(2, b"library on 2\\n")
warnings.warn("a warning"); logging.getLogger("trimesh").warning("a log")
logging.getLogger("fusion").warning("own note")
print("own \\x1b[31m line \\u202e", "gr\\u00f6\\u00dfe", "\\udcff")
sys.stderr.write("own error\\n")
"""


def run(program: str, **more: str) -> tuple[str, str]:
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, env={**os.environ, **more}, timeout=60, check=True
    )
    return done.stdout.decode(), done.stderr.decode()


def test_libraries_do_not_speak():
    out, err = run(NOISY.format(verbose=False), PYTHONIOENCODING="utf-8")
    assert out == "own \\x1b[31m line \\u202e größe \\udcff\n"
    assert err == "note: own note\nown error\n"


def test_they_do_when_all_is_told():
    out, err = run(NOISY.format(verbose=True), PYTHONIOENCODING="utf-8")
    assert "library on 1" in out
    assert all(text in err for text in ("library on 2", "a warning", "a log", "own note"))


def test_names_that_the_terminal_has_no_letters_for():
    out, _ = run(NOISY.format(verbose=False), PYTHONIOENCODING="ascii")
    assert "gr\\xf6\\xdfe" in out


def test_text_that_would_move_the_cursor_is_escaped():
    assert (
        printable("a\x1b[31mb\x07\u202ec\u200b\ud800é 日\u3000本")
        == "a\\x1b[31mb\\x07\\u202ec\\u200b\\ud800é 日\u3000本"
    )
    assert printable("a\nb", "\n") == "a\nb"
    assert "\x1b" not in str(FusionError("what", "na\x1b[2Jme", "fo\u202eund"))


@pytest.mark.parametrize("place", ["where", "found", "expected"])
def test_long_messages_are_cut_and_still_say_what_to_do(place):
    told = str(FusionError("what", **{place: "begin" + "x" * 5000 + "end"}, do="do this"))
    assert len(told) < LONGEST + 60
    assert "begin" in told and "end" in told and told.endswith("do this")
    told = str(FusionError("w" * 900, "p" * 900, "f" * 900, "e" * 900, "d" * 900))
    assert len(told) < LONGEST + 60


def test_options_say_how_far_to_trust(tmp_path, trusting):
    trusting(2.0, False)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link").symlink_to(tmp_path)
    assert main(["info", str(tmp_path / "no"), "--allow-gb", "5", "--follow-links"]) == 1
    limits.check_size(4.9e9, "x")
    assert inside.inside(tmp_path / "in", "link") == tmp_path / "in" / "link"
    assert main(["info", str(tmp_path / "no")]) == 1
    with pytest.raises(FusionError, match="2 GB"):
        limits.check_size(4.9e9, "x")
    with pytest.raises(FusionError, match="--follow-links"):
        inside.inside(tmp_path / "in", "link")
    assert main(["info", str(tmp_path / "no"), "--allow-gb", "nan"]) == 1


def test_a_fault_and_a_name_too_long_are_one_short_line(tmp_path):
    program = "import sys; from fusion.commands.main import main; sys.exit(main())"
    for name in ("x" * 3000, "a\x1b[2J"):
        done = subprocess.run([sys.executable, "-c", program, "info", name], capture_output=True, text=True, timeout=60)
        assert done.returncode == 1
        assert len(done.stderr.splitlines()) == 1 and len(done.stderr) < 800 and "\x1b" not in done.stderr


def test_json_is_left_as_it_is(tmp_path):
    program = "import sys; from fusion.commands.main import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", program, "sensor", "list", "--json"], capture_output=True, timeout=60)
    assert json.loads(done.stdout)
