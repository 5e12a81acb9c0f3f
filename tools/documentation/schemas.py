"""Writes docs/schemas/: JSON schemas of the files that others write and read, from the types that the readers use.

python -m tools.documentation.schemas            all of them
python -m tools.documentation.schemas --check    writes nothing; tells which are out of date, exit status 1
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from fusion.calibration.lens.boards.board import BoardFile
from fusion.discrepancy.verdict.content import Verdict
from fusion.files.output.publish import atomic_file
from fusion.files.schema import schema_of
from fusion.recording.native.camera_file import CameraFile
from fusion.sensor.files.sensor_fields import sensor_file
from fusion.simulation.scene.source import SceneFile

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "schemas"
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schemas() -> dict[str, dict[str, Any]]:
    """Every schema by the name of its file."""
    kinds = {"camera": CameraFile, "sensor": sensor_file(), "scene": SceneFile, "board": BoardFile, "verdict": Verdict}
    return {
        f"{name}.schema.json": {"$schema": DIALECT, "title": f"{name}.json"} | schema_of(kind)
        for name, kind in kinds.items()
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing, tell what is out of date")
    options = parser.parse_args()
    made = {FOLDER / name: json.dumps(schema, indent=1) + "\n" for name, schema in schemas().items()}
    if not options.check:
        FOLDER.mkdir(parents=True, exist_ok=True)
        for path, text in made.items():
            with atomic_file(path) as partial:
                partial.write_text(text, encoding="utf-8")
        return 0
    old = [path for path, text in made.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    print(
        "\n".join(f"{path.name} is out of date: run python -m tools.documentation.schemas" for path in old)
        or "up to date"
    )
    return bool(old)


if __name__ == "__main__":
    sys.exit(main())
