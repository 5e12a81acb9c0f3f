"""Signals end a run in one line with the status of a shell, and leave nothing half made behind."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

# a command that says when it is in the middle of its work, or when the result stands already
PROGRAM = """
import sys, time
from types import SimpleNamespace
from fusion.commands.console import run
from fusion.commands.catalogue import COMMANDS
from fusion.commands.options.results import add_output
def work(options):
    with options.claim.folder() as partial:
        (partial / "mesh.ply").write_text("whole")
        wait("middle")
    wait("end")
def wait(place):
    if place == sys.argv[4]:
        print(place, flush=True)
        time.sleep(30)
COMMANDS["try"] = "nothing"
sys.modules["fusion.commands.try"] = SimpleNamespace(
    EXAMPLE="", add_arguments=lambda parser: (add_output(parser, "a folder"), parser.add_argument("place")), run=work
)
raise SystemExit(run())
"""
STOPS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


def stopped(out: Path, place: str, number: int, ignored: bool = False) -> tuple[int, str]:
    """Exit status and what it said on stderr, of a run that got the signal there."""

    def before() -> None:
        signal.signal(number, signal.SIG_IGN if ignored else signal.SIG_DFL)

    command = [sys.executable, "-c", PROGRAM, "try", "-o", str(out), place]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=before
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"{place}\n"
        process.send_signal(number)
        if ignored:
            process.kill()
        said = process.communicate(timeout=20)[1]
    return process.returncode, said


@pytest.mark.parametrize("number", STOPS, ids=lambda number: number.name)
def test_a_stopped_run_tells_so_and_leaves_nothing(tmp_path, number):
    status, said = stopped(tmp_path / "out", "middle", number)
    assert status == 128 + number
    assert said.count("\n") == 1
    assert said.endswith("nothing was written\n")
    assert not list(tmp_path.iterdir())


def test_a_run_that_is_stopped_after_its_result_stands_says_that(tmp_path):
    status, said = stopped(tmp_path / "out", "end", signal.SIGTERM)
    assert status == 128 + signal.SIGTERM
    assert said == f"fusion try: terminated; the result was complete and is in {tmp_path / 'out'}\n"
    assert (tmp_path / "out" / "mesh.ply").read_text() == "whole"


def test_a_signal_that_is_to_be_ignored_is(tmp_path):
    """As `nohup` asks for."""
    assert stopped(tmp_path / "out", "middle", signal.SIGHUP, ignored=True) == (-signal.SIGKILL, "")


@pytest.mark.parametrize("module", ["signal", "argparse", "fusion.commands.main", "fusion.commands.recording.info"])
def test_ctrl_c_while_modules_are_loaded_is_one_line(module):
    program = f"""
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
for name in [name for name in sys.modules if name in ("signal", "argparse")]:
    del sys.modules[name]
class Press:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), {int(signal.SIGINT)})
sys.meta_path.insert(0, Press())
from fusion.commands.console import run
raise SystemExit(run())
"""
    done = subprocess.run(
        [sys.executable, "-c", program, "info", "nowhere"], capture_output=True, text=True, timeout=30
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "fusion: interrupted\n")


def test_ctrl_c_in_a_callback_is_not_lost():
    program = """
import os, signal, sys, time, weakref
signal.signal(signal.SIGINT, signal.default_int_handler)
from types import SimpleNamespace
from fusion.commands.console import run
from fusion.commands.catalogue import COMMANDS
class Thing:
    pass
def work(options):
    thing = Thing()
    seen = weakref.ref(thing, lambda _: os.kill(os.getpid(), signal.SIGINT))
    del thing
    time.sleep(10)
COMMANDS["try"] = "nothing"
sys.modules["fusion.commands.try"] = SimpleNamespace(EXAMPLE="", add_arguments=lambda parser: None, run=work)
raise SystemExit(run())
"""
    done = subprocess.run([sys.executable, "-c", program, "try"], capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stderr) == (130, "fusion try: interrupted\n")


def test_an_error_that_a_library_makes_of_a_signal_is_told_as_the_signal(monkeypatch, capsys):
    from types import SimpleNamespace

    from fusion.commands.catalogue import COMMANDS
    from fusion.commands.main import main

    def run(options) -> None:
        try:
            os.kill(os.getpid(), signal.SIGTERM)
        except KeyboardInterrupt as error:
            raise ImportError("numpy did not load") from error

    module = SimpleNamespace(EXAMPLE="", add_arguments=lambda parser: None, run=run)
    monkeypatch.setitem(COMMANDS, "try", "nothing, for a test")
    monkeypatch.setitem(sys.modules, "fusion.commands.try", module)
    before = signal.getsignal(signal.SIGTERM)
    assert main(["try"]) == 143
    assert capsys.readouterr().err == "fusion try: terminated\n"
    assert signal.getsignal(signal.SIGTERM) == before
