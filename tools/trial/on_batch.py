"""The trial as a batch: a case is a job with a key, run on Dask's workers, and never done twice.

What a job is told is a small file, an `Order`; the worker makes the case, seals its label, lets the engine answer and
scores. Its folder appears whole or not at all; a case whose worker dies is given to another one. The key knows
the order and the program's version, not the program's text: after a change to the engine take another folder.
"""

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from fusion.batch.listing import Item
from fusion.batch.run import Batch, BatchSettings, run_batch
from fusion.files.output.publish import output_folder
from tools.trial.case import Order, tried

PROJECT = Path(__file__).resolve().parents[2]
RUNNER = "tools.trial.on_batch:run"


def tried_on_workers(
    orders: Sequence[Order], home: Path, workers: int, scheduler: str | None = None
) -> Iterator[dict[str, Any]]:
    """Results in the order of the orders; `absent` in place of one where a case could not be made or ended."""
    listed = home / "orders"
    listed.mkdir(parents=True, exist_ok=True)
    for order in orders:
        told = {**asdict(order), "output": "", "shared": None if order.shared is None else str(order.shared.resolve())}
        (listed / f"{order.name}.json").write_text(json.dumps(told), encoding="utf-8")
    items = [Item(order.name, listed / f"{order.name}.json") for order in orders]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(PROJECT), os.environ.get("PYTHONPATH")]))
    batch = run_batch(items, ["{rec}", "{out}"], home, BatchSettings(workers, scheduler, runner=RUNNER))
    return _results(batch, home)


def run(words: list[str]) -> int:
    """A job: the file of the order, and the folder that appears when it is done."""
    told, out = json.loads(Path(words[0]).read_text(encoding="utf-8")), Path(words[1])
    order = Order(**told | {"seed": tuple(told["seed"]), "shared": told["shared"] and Path(told["shared"])})
    # a seal stands where others see it before the engine starts, and whatever becomes of the job
    with output_folder(out) as partial:
        result = tried(replace(order, output=partial, seals=Path("seals.txt").resolve()))
        if "absent" in result:
            print(f"fusion trial: {result['absent']}")
            raise SystemExit(1)
    return 0


def _results(batch: Batch, home: Path) -> Iterator[dict[str, Any]]:
    for row in batch.rows:
        if row.status != "done":
            yield {"absent": f"{row.name}: {row.status}, {row.reason}"}
            continue
        yield json.loads((home / row.folder / f"{row.name}.json").read_text(encoding="utf-8"))
