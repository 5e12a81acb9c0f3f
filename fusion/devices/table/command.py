"""A table that a command of the user's own turns."""

import shlex
import subprocess
import threading

from fusion.errors import DeviceError

LONGEST = 120.0  # [s] for one step (guess: a slow table takes a minute for a turn)
EXAMPLE = "my_table --to {angle}"


class Command:
    """Runs a command for each step and takes its end for the table standing still.

    Args:
        text: words as a shell takes them, but no shell is run. `{angle}` becomes the angle to turn to [deg], counted
            from the start, `{step}` by how much to turn. With `{angle}` it is run for the start too, with 0.

    Raises:
        DeviceError: no such words in it.
    """

    def __init__(self, text: str) -> None:
        self.text, self._at = text, 0.0
        self._absolute = "{angle}" in text
        self._stopped = threading.Event()
        self._process: subprocess.Popen[str] | None = None
        if not self._absolute and "{step}" not in text:
            raise DeviceError("the table's command does not say where to turn", "--table", text, EXAMPLE)
        try:
            self._words = shlex.split(text)
        except ValueError as error:
            raise DeviceError("the table's command cannot be taken apart", "--table", error, EXAMPLE) from error

    def go(self, angle: float) -> float:
        """Turn to an angle [deg]; the angle. Raises DeviceError: it cannot be run, failed, or did not end."""
        step, self._at = angle - self._at, angle
        if (step or self._absolute) and not self._stopped.is_set():
            values = {"{angle}": f"{angle:.4f}", "{step}": f"{step:.4f}"}
            words = [_filled(word, values) for word in self._words]
            self._run(words)
        return angle

    def stop(self) -> None:
        """End the command that runs; from any thread."""
        self._stopped.set()
        if self._process is not None:
            self._process.kill()

    def close(self) -> None:
        """As `stop`."""
        self.stop()

    def _run(self, words: list[str]) -> None:
        shown = shlex.join(words)
        try:
            self._process = subprocess.Popen(
                words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
            )
        except OSError as error:
            raise DeviceError("the table's command cannot be run", shown, error.strerror) from error
        if self._stopped.is_set():  # meanwhile, by another thread
            self._process.kill()
        try:
            said = self._process.communicate(timeout=LONGEST)[1]
        except subprocess.TimeoutExpired as error:
            self._process.kill()
            self._process.communicate()
            raise DeviceError("the table's command does not end", shown, f"after {LONGEST:g} s") from error
        if self._process.returncode and not self._stopped.is_set():
            last = said.strip().rpartition("\n")[2]
            found = f"status {self._process.returncode}" + (f", {last}" if last else "")
            raise DeviceError("the table's command failed", shown, found, "status 0 once the table stands")


def _filled(word: str, values: dict[str, str]) -> str:
    for name, value in values.items():
        word = word.replace(name, value)
    return word
