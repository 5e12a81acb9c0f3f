"""Hand-held walks that come back to where they began: is the loop closed, and does the scan know it?

    python -m tools.sets.loops -o OUT --seed 2                  every scene
    python -m tools.sets.loops -o OUT --scenes lost --made REC  keep the recordings in REC, or take those that are there

Five simulated scenes, rendered by code that shares nothing with the program (tools/sets/loop_scenes): `plain`, a room
one of whose walls is bare; `lost`, a room in which the camera is jerked half way and sees nothing for some frames;
`carried`, where it is covered and carried elsewhere; `table`, a thing on a table, walked round; `open`, a walk that
does not come back. And `rpy`, real: TUM RGB-D freiburg1_rpy. `fusion reconstruct` runs as a user would run it, and
Open3D's frame-to-model tracking on the same frames.

ATE: rms of the camera centres after rigid alignment (as evo), over the frames that `fusion` placed. Drift: the last
frame's pose against the first's, beside the truth; gap: rms by which that moves what the last frame sees. Mesh: median
and 95 % of its distances to the truth, aligned by the trajectory; twice: share of it farther off than 3 cm (a thing on
a table: 1 cm); sure: share within its own 90 % interval, laid on the truth. Asked: ATE at most 0.7 of Open3D's, gap
and share within limits, and that exit status, terminal and settings.json say what is true. Exit status 1 where not all
of it is so. `OUT/table.txt` and `OUT/table.json` hold what is printed.
"""

import argparse
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # products of small matrices: threads would only wait

from tools.sets.loop_scenes.judged import FR1, Judged, judged, truth_of, truth_of_fr1
from tools.sets.loop_scenes.making import FULL, SCENES, SMALL, make
from tools.sets.loop_scenes.table import HEAD, as_json, lines, summary


def main() -> int:
    """Make, run, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--scenes", nargs="+", choices=[*SCENES, FR1], default=[*SCENES, FR1], metavar="NAME")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--made", type=Path, help="folder of recordings: those that are there are used, others kept")
    parser.add_argument("--small", action="store_true", help="pictures of 320 x 240")
    parser.add_argument(
        "--only-fusion", action="store_true", help="without Open3D, and without what is asked beside it"
    )
    parser.add_argument("--make-only", action="store_true", help="write the recordings and stop")
    options = parser.parse_args()
    made, scenes = options.made or options.output / "made", list[Judged]()
    if not options.make_only:
        print(HEAD, flush=True)
    for scene in options.scenes:
        name = FR1 if scene == FR1 else f"{scene}_seed{options.seed}{'_small' if options.small else ''}"
        if scene == FR1:
            recording = shared() / "data/tum_fr1_rpy"
        else:
            recording = made / name / "recording"
            if not recording.is_dir():
                begin = time.monotonic()
                make(scene, options.seed, made / name, SMALL if options.small else FULL)
                print(f"{name}: made in {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
        if options.make_only:
            continue
        truth = truth_of_fr1(recording) if scene == FR1 else truth_of(made / name / "truth")
        scenes.append(judged(name, recording, truth, options.output / name, options.only_fusion))
        print(lines(scenes[-1]), flush=True)
        text = "\n".join([HEAD, *map(lines, scenes), summary(scenes), ""])
        (options.output / "table.txt").write_text(text, encoding="utf-8")
        (options.output / "table.json").write_text(as_json(scenes), encoding="utf-8")
    if scenes:
        print(summary(scenes))
    return int(any(one.misses for one in scenes))


def shared() -> Path:
    """The folder with the real recordings."""
    return Path(os.environ.get("FUSION_SHARED") or Path(__file__).resolve().parents[2] / "../shared")


if __name__ == "__main__":
    raise SystemExit(main())
