"""`fusion explain`: where simulation and recording differ, which physics is missing, and the better model."""

import argparse
import json
import logging
import shutil
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from fusion.commands.options.results import add_output, add_topic, made
from fusion.commands.terminal.screen import took

if TYPE_CHECKING:
    from fusion.discrepancy.verdict.claim import Claim
    from fusion.discrepancy.verdict.content import Verdict
    from fusion.recording.recording import Recording

WIDEST = 110  # columns: longer lines are hard to read
LABEL = 12  # columns of the words on the left
NAMES = 8  # that are listed one by one
EXAMPLE = "fusion explain case/rec_* --sensor case/sensor.json -o out"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's options."""
    add = parser.add_argument
    add(
        "recordings",
        type=Path,
        nargs="+",
        metavar="REC",
        help="recordings of known scenes: scene.json with mesh, poses",
    )
    add("--sensor", required=True, metavar="S", help="what is known of the sensor: sensor.json or a preset's name")
    add_output(parser, "folder for verdict.json, sensor.json and report.html")
    add(
        "--simulated",
        type=Path,
        nargs="+",
        metavar="SIM",
        default=[],
        help="what any simulator made of the same scenes, one recording for each REC, in the same order",
    )
    add("--camera", metavar="C", help="camera.json, a preset's name or fx,fy,cx,cy, instead of the recordings' own")
    add_topic(parser)
    add("--json", action="store_true", help="print the verdict as one JSON object")


def left_out(recording: "Recording") -> list[str]:
    """What of a recording takes no part, in sentences: what its reader left out, and frames without a stated pose."""
    placed = None if recording.poses is None else recording.poses.at(recording.timestamps).valid
    if placed is None or placed.all():
        return list(recording.warnings)
    text = f"{int((~placed).sum())} of {len(recording)} frames have no stated pose at their time: left out"
    return [*recording.warnings, text]


def run(options: argparse.Namespace) -> None:
    """Explain and write the results."""
    from msgspec.structs import replace

    from fusion.discrepancy.explain import explain
    from fusion.discrepancy.verdict.verdict import verdict_of
    from fusion.files.json_values import json_text, json_values
    from fusion.progress import seconds, stage
    from fusion.recording.open import open_recording
    from fusion.report.explanations.claim_sections import with_masks
    from fusion.report.explanations.explanation import explanation_report
    from fusion.sensor.files.sensor_file import read_sensor, write_sensor

    sensor = read_sensor(options.sensor)
    recordings = [open_recording(path, options.camera, options.topic) for path in options.recordings]
    simulated = [open_recording(path, options.camera) for path in options.simulated]
    found = explain(recordings, sensor, simulated)
    for recording in (*recordings, *simulated):
        for text in left_out(recording):
            logging.getLogger("fusion").warning("%s: %s", recording.path, text)
    with options.claim.folder() as partial:
        verdict = with_masks(partial, found, verdict_of(found))
        if options.report:
            with stage("report"):
                explanation_report(partial, found, verdict)
        verdict = replace(verdict, seconds=seconds())
        (partial / "verdict.json").write_text(json_text(verdict) + "\n")
        write_sensor(partial / "sensor.json", found.sensor)
    if options.json:
        print(json.dumps(json_values(verdict)))
    else:
        width = min(WIDEST, shutil.get_terminal_size((100, 24)).columns)
        last = [
            *made(options, "verdict", "sensor", "report", width=LABEL),
            f"{'took':<{LABEL}}{took(verdict.seconds or {})}",
        ]
        print("\n".join([*verdict_lines(verdict, width), *last]))


def verdict_lines(verdict: "Verdict", width: int) -> list[str]:
    """The lines of a verdict."""
    lines = textwrap.wrap(verdict.headline, width)
    for number, claim in enumerate(verdict.missing, start=1):
        lines += ["", *_claim(f"{number}.", claim, True, width)]
    for claim in verdict.indicated:
        lines += ["", *_claim("?", claim, False, width)]
    return [*lines, "", *_rest(verdict, width)]


def _claim(mark: str, claim: "Claim", established: bool, width: int) -> Iterator[str]:
    from fusion.discrepancy.verdict.words import how_sure, name_of, numbers_of, rivals_said, size_of, what_it_is
    from fusion.sensor.words.in_words import plain

    yield from textwrap.wrap(f"{mark} {name_of(claim)}: {what_it_is(claim)}", width, subsequent_indent="   ")
    if size := size_of(claim):
        yield from _row("size", size, width)
    yield from _row("how sure", how_sure(claim, established), width)
    for name, values in numbers_of(claim):
        yield from _row(name, "; ".join(values), width)
    if claim.unknown or claim.where.region or claim.channel != "bias":
        yield from _row("where", claim.where.text.removeprefix(f"{claim.effect}: "), width)
    if alike := rivals_said(claim):
        yield from _row("or it is", f"{', '.join(map(plain, alike))}: these recordings show the same for each", width)
    if claim.record_next:
        yield from _row("record next", plain(claim.record_next), width)


def _rest(verdict: "Verdict", width: int) -> Iterator[str]:
    """What took no part, what was looked for in vain, and what these recordings cannot show."""
    from fusion.sensor.words.in_words import plain

    for outlier in verdict.outliers[:NAMES]:
        yield from _row("left out", f"{outlier.recording}: {outlier.text.removesuffix('; left out')}", width)
    unseen = verdict.invisible
    if unseen:
        named = ", ".join(map(plain, unseen[:NAMES])) + (", ..." if len(unseen) > NAMES else "")
        yield from _row("not seen", f"{len(unseen)} effects leave no trace in such recordings: {named}", width)
    if verdict.limits:
        looked = f"{len(verdict.limits)} other effects; the report says how large each could still be"
        yield from _row("not found", looked, width)


def _row(label: str, text: str, width: int) -> list[str]:
    return textwrap.wrap(text, width, initial_indent=f"   {label:<{LABEL - 1}} ", subsequent_indent=" " * (LABEL + 3))
