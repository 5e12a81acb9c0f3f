"""Ctrl-C between any two steps of the code that claims and publishes leaves nothing beside the output."""

import gc
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import CASES, make_inputs

TRACED = ("/fusion/files/", "/fusion/commands/main.py", "contextlib.py")


class Press:
    """Raises KeyboardInterrupt at the `number`-th step (0: never) of the traced files."""

    def __init__(self, number: int) -> None:
        self.number, self.count, self.at = number, 0, ""

    def __call__(self, frame, event, arg):
        if not any(part in frame.f_code.co_filename for part in TRACED):
            return None
        frame.f_trace_opcodes = True
        return self.step

    def step(self, frame, event, arg):
        self.count += event == "opcode"
        if event == "opcode" and self.count == self.number:
            sys.settrace(None)
            self.at = f"{frame.f_code.co_filename}, line {frame.f_lineno}"
            raise KeyboardInterrupt
        return self.step


def pressed(inputs: Path, work: Path, number: int) -> Press:
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    press, before = Press(number), sys.gettrace()
    try:
        sys.settrace(press)
        CASES[0].run(inputs, work / "out.ply")
    except KeyboardInterrupt:
        pass  # in the first or last step of `main`: told by the console program
    finally:
        sys.settrace(before)
    return press


# a file that was opened in the very step before is closed by the end of the program
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("every", [499, pytest.param(1, marks=pytest.mark.slow)])
def test_ctrl_c_at_any_step_leaves_nothing_beside(every, tmp_path, capsys):
    make_inputs(tmp_path)
    work = tmp_path / "work"
    steps = pressed(tmp_path, work, 0).count
    assert steps > 1000
    gc.disable()  # what only the collector would tidy up is not tidied up when a program ends
    try:
        for number in range(1, steps + 1, every):
            press = pressed(tmp_path, work, number)
            assert {path.name for path in work.iterdir()} <= {"out.ply"}, press.at
    finally:
        gc.enable()
