"""
Many recordings
===============

The sensor bench over a folder of recordings, on two workers; what was done is not done again. Needs the extra
``batch``.
"""

import csv
import tempfile
from dataclasses import replace
from pathlib import Path

import fusion
from fusion.batch.listing import items_in
from fusion.batch.run import BatchSettings, run_batch

WORDS = ["evaluate", "{rec}", "-o", "{out}", "--no-report"]


def make(folder: Path) -> None:
    """Three walls, and one folder that is no recording."""
    camera = fusion.Camera(160, 120, fx=144.0, fy=144.0, cx=79.5, cy=59.5)
    for name in ("kinect-v1", "azure-kinect", "realsense-d415"):
        wall = replace(fusion.built_in("wall", {"distance_m": 1.0, "frames": 20}), camera=camera)
        fusion.write_simulation(folder / name, fusion.simulate(wall, fusion.read_sensor(name), seed=1))
    (folder / "notes").mkdir()
    (folder / "notes" / "read_me.txt").write_text("no recording")


# %%
# Workers are processes that begin by reading this file: the work stands behind ``__main__``.

if __name__ == "__main__":
    place = Path(tempfile.mkdtemp())
    make(place / "walls")
    items, _ = items_in(place / "walls")
    print(run_batch(items, WORDS, place / "out", BatchSettings(workers=2)))
    print(run_batch(items, WORDS, place / "out", BatchSettings(workers=2)))  # nothing is left to do

# %%
# Every recording has a row, with the reason where it was refused, and all that the result's JSON files say.

if __name__ == "__main__":
    with (place / "out" / "results.csv").open(encoding="utf-8") as table:
        for row in csv.DictReader(table):
            print(f"{row['recording']}: {row['status']}. {row['reason'] or row['evaluation.summary']}")
