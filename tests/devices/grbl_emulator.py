"""A turntable at a pseudo-terminal that speaks GRBL 1.1; written from Grbl's own description alone (gnea/grbl,
doc/markdown: interface, jogging, realtime_cmds). Shares nothing with the driver.

Faults: "mute" answers nothing at all; "talker" is something else that speaks; "locked" begins in alarm; "refuses" and
"stuck" take no jog, or do not move; "alarm", "unplug", "freeze", "reset" happen in the middle of the move to the third
place; "overhears" misses every second question.
"""

import os
import pty
import re
import threading
import time
import tty

import pytest

JOG = re.compile(r"\$J=((?:G\d+)*)X(-?[\d.]+)F([\d.]+)$")


class Emulated:
    """`name` is the port; it turns `speed` degrees a second and greets when it is opened, as an Arduino does."""

    def __init__(self, fault: str = "", speed: float = 400.0, greets: bool = True, work: bool = False) -> None:
        self.fault, self.speed, self.work = fault, speed, work
        try:
            self.master, slave = pty.openpty()
        except OSError:
            pytest.skip("no pseudo-terminals here")  # a chroot without /dev/pts
        tty.setraw(slave)
        self.name = os.ttyname(slave)
        os.close(slave)  # so that reading fails until somebody opens the port
        self.greets, self.opened = greets and fault not in ("mute", "talker"), False
        self.state = "Alarm" if fault == "locked" else "Idle"
        self.begin = self.goal = 123.5  # machine position: it may stand anywhere when it is switched on
        self.since, self.jogs, self.asked, self.cancelled = time.monotonic(), 0, 0, False
        self.lines: list[str] = []
        self.dead = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def __enter__(self) -> "Emulated":
        return self

    def __exit__(self, *what: object) -> None:
        self.dead.set()
        self.thread.join(2)
        if self.fault != "unplug":
            os.close(self.master)

    @property
    def place(self) -> float:
        """Where the axis is now [mm, which are degrees]."""
        way = self.goal - self.begin
        done = min(1.0, (time.monotonic() - self.since) * self.speed / max(abs(way), 1e-9))
        return self.begin + done * way

    @property
    def standing(self) -> float | None:
        """The angle from the start, or None while it moves."""
        return None if self.place != self.goal else self.goal - 123.5

    def say(self, text: str) -> None:
        os.write(self.master, text.encode() + b"\r\n")

    def run(self) -> None:
        rest = b""
        os.set_blocking(self.master, False)
        while not self.dead.is_set():
            try:
                byte = os.read(self.master, 1)
            except BlockingIOError:
                byte = b""
            except OSError:  # nobody has it open
                self.opened = False
                time.sleep(0.001)
                continue
            if not self.opened:
                self.reset()
            self.happen()
            if not byte:
                time.sleep(0.001)
                continue
            if self.fault in ("mute", "talker") or self.state == "Frozen":
                continue
            if byte == b"?":
                self.asked += 1
                if self.fault != "overhears" or self.asked % 2 == 0:
                    self.report()
            elif byte in (b"\x85", b"!"):
                self.begin = self.goal = self.place
                self.cancelled = True
            elif byte == b"\n":
                line, rest = rest.decode().strip(), b""
                self.lines.append(line)
                self.answer(line)
            else:
                rest += byte

    def reset(self) -> None:
        """As an Arduino is when its port is opened."""
        self.opened = True
        if self.greets:
            self.say("\r\nGrbl 1.1h ['$' for help]")
            if self.fault == "locked":
                self.say("[MSG:'$H'|'$X' to unlock]")

    def report(self) -> None:
        state = self.state if self.state != "Idle" or self.place == self.goal else "Jog"
        frame, shift = ("WPos", 20.0) if self.work else ("MPos", 0.0)
        self.say(f"<{state}|{frame}:{self.place - shift:.3f},0.000,0.000|FS:0,0|WCO:20.000,0.000,0.000>")

    def answer(self, line: str) -> None:
        if line == "$$":
            self.say("$10=1")
            self.say(f"$13={int(self.fault == 'inches')}")
            self.say("ok")
        elif self.state == "Alarm":
            self.say("error:9")
        elif jog := JOG.match(line):
            self.jog(jog[1], float(jog[2]))
        else:
            self.say("ok" if not line else "error:20")

    def jog(self, words: str, to: float) -> None:
        if self.fault == "refuses":
            self.say("error:15")
            return
        self.jogs += 1
        if self.fault != "stuck":
            if "G53" not in words:  # in work coordinates
                to += 20.0
            self.begin, self.goal, self.since = self.place, to, time.monotonic()
        self.say("ok")

    def happen(self) -> None:
        """A fault in the middle of a move; what is not grbl talks all the time."""
        if self.fault == "talker":
            os.write(self.master, b"$GPGGA,123519,4807.038,N\r\n")
            time.sleep(0.05)
        if self.jogs != 3 or self.place == self.goal or time.monotonic() - self.since < 0.02:
            return
        if self.fault == "alarm":
            self.begin = self.goal = self.place
            self.state = "Alarm"
            self.say("ALARM:1")
            self.say("[MSG:Reset to continue]")
        elif self.fault == "reset":
            self.begin = self.goal = self.place
            self.say("\r\nGrbl 1.1h ['$' for help]")
        elif self.fault == "freeze":
            self.state = "Frozen"
        elif self.fault == "unplug":
            os.close(self.master)
            self.dead.set()
