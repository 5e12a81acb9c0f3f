"""The one rule by which every run is judged, whatever its input; each sentence of it is one function here."""

import json
import re
import unicodedata
from collections.abc import Iterator

from broken.case import ACCEPTED, REFUSED, TOLD, Case
from broken.runner import LIMIT_BYTES, LIMIT_S, Ran
from broken.snapshot import changes, within

LONGEST = 700  # letters of a message
# how other people's lines begin or look
FOREIGN = re.compile(
    r"Traceback \(most recent|^  File \"|libpng|libjpeg|Corrupt JPEG|Premature end|OpenCV\(|"
    r"cv2\.error|\[ ?(WARN|ERROR|INFO|DEBUG)|"
    r"Warning:|warnings\.warn|\[Open3D|\[Taichi\]|Taichi|^\[E |^\[W |RPly|tinyobj|tinygltf|Segmentation|core dumped|"
    r"terminate called|Errno \d|object at 0x|Exception ignored|During handling of|qhull|QH\d{4}",
    re.MULTILINE,
)
TOO_MUCH = "time: of the processor"
PROGRESS = re.compile(r"^ +\d+ s  ")  # long work tells where it is, every 5 s
FAULT = b"a fault of the program itself"  # what the program says of an error that nobody foresaw
SECRET = "OUTSIDE-SECRET"  # stands in every file that cases put outside a recording
STOLEN = (SECRET.encode(), b"root:x:0:")


def judged(case: Case, ran: Ran) -> list[str]:
    """All that is wrong with a run: nothing, where the program keeps its word."""
    return list(_all(case, ran))


def _all(case: Case, ran: Ran) -> Iterator[str]:
    yield from _ending(case, ran)
    yield from _bounds(ran)
    yield from _printed(ran)
    yield from _line(case, ran)
    yield from _left_behind(case, ran)
    yield from _reaching(case, ran)
    if ran.status == 0:
        yield from _results(case, ran)


def _ending(case: Case, ran: Ran) -> Iterator[str]:
    if ran.ended:
        return  # told by _bounds
    if ran.status not in (0, 1, 2):
        yield f"crash: exit status {ran.status}"
    elif FAULT in ran.stderr:
        yield f"crash: {said(ran)[-1][-150:]}"
    elif case.expected is REFUSED and ran.status == 0:
        yield "accepted: should be refused"
    elif case.expected is TOLD and ran.status == 0 and not _named(case, ran.stdout + ran.stderr):
        yield f"silent: accepted without a word about {' or '.join(case.where)}"
    elif case.expected is ACCEPTED and ran.status != 0:
        yield f"refused: should be accepted, exit status {ran.status}"


def _named(case: Case, printed: bytes) -> bool:
    return any(word in printed.decode("utf-8", "replace") for word in case.where)


def _bounds(ran: Ran) -> Iterator[str]:
    # cores are shared: what counts is the work done, and waiting only where it is endless
    if ran.cpu > LIMIT_S:
        yield f"{TOO_MUCH} {ran.cpu:.0f} s in {ran.seconds:.0f} s" + (", ended" if ran.ended else "")
    elif ran.ended == "time":
        yield f"time: {ran.seconds:.0f} s, ended"
    if ran.peak > LIMIT_BYTES:
        yield f"memory: {ran.peak / 1e9:.1f} GB" + (", ended" if ran.ended else "")


def _printed(ran: Ran) -> Iterator[str]:
    for name, raw in (("stdout", ran.stdout), ("stderr", ran.stderr)):
        try:
            text = raw.decode("utf-8")
        except UnicodeDecodeError:
            yield f"letters: {name} is no UTF-8"
            text = raw.decode("utf-8", "replace")
        if found := FOREIGN.search(text):
            line = next(line for line in text.splitlines() if found.group().strip() in line)
            yield f"foreign line on {name}: {line.strip()[:100]}"
        odd = {c for c in text if c != "\n" and _commands_a_terminal(c)}
        if odd:
            yield f"control characters on {name}: {sorted(map(ascii, odd))}"


def _commands_a_terminal(letter: str) -> bool:
    """Control characters, and those that turn the direction of writing or end a line unseen."""
    return (
        unicodedata.category(letter) in ("Cc", "Zl", "Zp")
        or letter in "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
    )


def said(ran: Ran) -> list[str]:
    """The lines on stderr that are no progress."""
    return [line for line in ran.stderr.decode("utf-8", "replace").splitlines() if not PROGRESS.match(line)]


def _line(case: Case, ran: Ran) -> Iterator[str]:
    if ran.ended or ran.status not in (1, 2):
        return
    lines = said(ran)
    if ran.status == 1 and ran.words[:1] == ["info"] and not lines and ran.stdout:
        # a report of what is wrong is the result that was asked for; it is the report that says where
        if case.where and not _named(case, ran.stdout):
            yield f"where: the report does not say one of {' or '.join(case.where)}"
        return
    if ran.status == 1 and len(lines) != 1:
        yield f"lines: {len(lines)} on stderr instead of 1"
    if not lines:
        return
    last = lines[-1]
    if ran.status == 1 and not last.startswith("fusion "):
        yield f"line does not begin with the command: {last[:60]}"
    if len(last) > LONGEST:
        yield f"long: the line has {len(last)} letters"
    if case.where and not _named(case, last.encode()):
        yield f"where: line does not say one of {' or '.join(case.where)}: {last[:160]}"


def _left_behind(case: Case, ran: Ran) -> Iterator[str]:
    if ran.ended:
        return  # it had no chance to clear up
    changed = changes(ran.before, ran.after, _results_at(case, ran) if ran.status == 0 else ())
    if changed:
        yield f"files: {'; '.join(changed[:4])}" + (f" and {len(changed) - 4} more" if len(changed) > 4 else "")
    partial = [name for name in ran.after if ".partial" in name and name not in ran.before]
    if partial and ran.status == 0:
        yield f"files: {partial[0]!r} left in the result"
    if ran.scratch:
        yield f"files: {ran.scratch[:3]} left in TMPDIR"


def _results_at(case: Case, ran: Ran) -> tuple[str, ...]:
    """Where a result may be: under its name, and where that leads if it is a link that was there before."""
    kind, _, target = ran.before.get(case.out, "").partition(" ")
    return (case.out, target.split("/")[0]) if kind == "link" else (case.out,)


def _reaching(case: Case, ran: Ran) -> Iterator[str]:
    if ran.events:
        yield f"reaches out: {ran.events[0]}"
    if "outside" not in ran.words:  # a folder that the user names may be read
        for name in ran.read_outside:
            yield f"reaches out: {name} was read"
    named = any("/etc/passwd" in word for word in ran.words)  # a file that the user names may be quoted to the user
    for raw, name in ((ran.stdout, "stdout"), (ran.stderr, "stderr")):
        if not named and any(word in raw for word in STOLEN):
            yield f"reaches out: content of a file outside on {name}"
    for name in ran.after:
        path = ran.folder / name
        if within(name, case.out) and path.is_file() and any(word in path.read_bytes() for word in STOLEN):
            yield f"reaches out: content of a file outside in {name}"


def _results(case: Case, ran: Ran) -> Iterator[str]:
    text = ran.stdout.decode("utf-8", "replace")
    if "--json" in ran.words:
        yield from _strict(text, "stdout")
    for name in ran.after:
        if within(name, case.out) and name.endswith(".json") and ran.before.get(name) != ran.after[name]:
            yield from _strict((ran.folder / name).read_text(encoding="utf-8"), name)
    if case.look is not None and (wrong := case.look(ran.folder, text)):
        yield f"nonsense: {wrong}"


def _strict(text: str, name: str) -> Iterator[str]:
    def refuse(word: str) -> None:
        raise ValueError(f"{word} is no JSON")

    try:
        json.loads(text, parse_constant=refuse)
    except ValueError as error:
        yield f"nonsense: {name}: {str(error)[:80]}"
