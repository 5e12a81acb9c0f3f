"""Every public entry point from two threads at once, over and over: how many results differ from one thread's.

    python -m tools.endurance.thread_rounds [--rounds 100] [--seed 0]

In each round both threads go through all calls of tests/threads/calls.py, each with inputs of its own and in an order
of its own, so that in the end calls of all kinds have met. Every result is compared bit by bit, files included, with
what the same call gave before the threads were started. The exit status is 1 if any differs.
"""

import argparse
import os
import shutil
import sys
import tempfile
import threading
import time
from itertools import count
from pathlib import Path
from random import Random
from typing import Any

TESTS = Path(__file__).resolve().parents[2] / "tests" / "threads"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of the orders")
    options = parser.parse_args()
    sys.path.insert(0, str(TESTS))
    from side_by_side import switching_often

    folder, start = Path(tempfile.mkdtemp(prefix="fusion-threads-")), time.perf_counter()
    try:
        rounds = Rounds(folder, options.seed)
        print(f"{len(rounds.calls)} calls, twice one after the other: {time.perf_counter() - start:.0f} s", flush=True)
        with switching_often():
            for n in range(options.rounds):
                rounds.run()
                if n % 10 == 9 or n == options.rounds - 1:
                    print(f"{n + 1} rounds, {time.perf_counter() - start:.0f} s, {rounds.told()}", flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f"load of the machine at the end: {os.getloadavg()[0]:.1f}")
    return 1 if rounds.wrong else 0


class Rounds:
    """Two threads, what each should get, and what was wrong so far."""

    def __init__(self, folder: Path, seed: int) -> None:
        from calls import HEAVY, LIGHT
        from inputs import made

        self.calls = [*LIGHT, *HEAVY]
        self.folder, self.numbers = folder, count()
        self.random = Random(seed)
        self.inputs = [made(folder / f"inputs_{n}", n + 1) for n in range(2)]
        self.expected = [[self._result(call, n) for call in self.calls] for n in range(2)]
        for n in range(2):  # what is different without threads says nothing about them
            for call, known in zip(self.calls, self.expected[n], strict=True):
                assert self._result(call, n) == known, f"{call.__name__} gives something else every time"
        self.compared = 0
        self.wrong: list[str] = []

    def run(self) -> None:
        """One round."""
        orders = [self.random.sample(range(len(self.calls)), len(self.calls)) for _ in self.inputs]
        threads = [threading.Thread(target=self._work, args=(n, order)) for n, order in enumerate(orders)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def told(self) -> str:
        """The figure."""
        return f"{self.compared} results compared, {len(self.wrong)} differences {self.wrong[:5] or ''}"

    def _work(self, n: int, order: list[int]) -> None:
        for k in order:
            try:
                same = self._result(self.calls[k], n) == self.expected[n][k]
            except Exception as error:
                self.wrong.append(f"{self.calls[k].__name__}: {error!r}")
            else:
                self.compared += 1
                if not same:
                    self.wrong.append(self.calls[k].__name__)

    def _result(self, call: Any, n: int) -> dict[str, Any]:
        from side_by_side import flat

        out = self.folder / str(next(self.numbers))
        out.mkdir()
        try:
            return flat(call(self.inputs[n], out))
        finally:
            shutil.rmtree(out)


if __name__ == "__main__":
    raise SystemExit(main())
