"""depth.txt: broken lines, names that reach out, odd files in its place."""

from collections.abc import Iterator
from pathlib import Path

from broken.case import ACCEPTED, EITHER, REFUSED, Case
from broken.crossing import DEPTH_READERS, SKIPPING, Break, Edit, crossed
from broken.odd_files import NO_FILE, encodings, fifo, folder, link, unix_socket

SURE = ("convert", "reconstruct", "evaluate", "turntable", "explain")  # info may describe what is wrong
WHOLE = ("convert",)  # may not leave a frame out
OTHERS = ("convert", "info", "reconstruct", "turntable", "evaluate", "depth", "explain")
NAME = "depth/000000.png"


def line(number: int, text: str | bytes) -> Edit:
    """Put another line in place of the n-th frame's."""
    raw = text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text

    def edit(rec: Path) -> None:
        path = rec / "depth.txt"
        lines = path.read_bytes().splitlines()
        frames = [n for n, it in enumerate(lines) if not it.startswith(b"#")]
        lines[frames[number]] = raw
        path.write_bytes(b"\n".join(lines) + b"\n")

    return edit


def content(change: object) -> Edit:
    """Another content, or the old one changed by a function."""

    def edit(rec: Path) -> None:
        path = rec / "depth.txt"
        path.write_bytes(change(path.read_bytes()) if callable(change) else change)  # type: ignore[arg-type]

    return edit


def stamps(change: object) -> Edit:
    """Every time stamp changed by a function of its number."""

    def edit(rec: Path) -> None:
        path = rec / "depth.txt"
        frames = [it for it in path.read_text(encoding="utf-8").splitlines() if not it.startswith("#")]
        told = [f"{change(n)} {it.split()[1]}" for n, it in enumerate(frames)]  # type: ignore[operator]
        path.write_text("\n".join(told) + "\n", encoding="utf-8")

    return edit


def named(put: Edit, name: str = "depth/odd.png") -> Edit:
    """The first frame's file is something odd."""

    def edit(rec: Path) -> None:
        put(rec / name)
        line(0, f"3600.0 {name}")(rec)

    return edit


def lines() -> Iterator[Break]:
    """Texts that are no line of a table, or one that means nothing."""
    here = ("depth.txt",)
    refused = {
        "no frames": b"# only a comment\n",
        "blank": b"\n\n \n",
        "a PNG in its place": b"\x89PNG\r\n\x1a\n" + bytes(range(256)),
        "JSON in its place": b'{"frames": []}',
        "NUL bytes": b"\0" * 5000,
        "one long line": b"1 " + b"x" * 5_000_000,
    }
    for name, told in refused.items():
        yield Break(name, content(told), REFUSED, (*here, "rec/xxx"), SURE)
    words = {
        "a stamp alone": "3600.0",
        "a name alone": NAME,
        "stamp nan": f"nan {NAME}",
        "stamp inf": f"inf {NAME}",
        "stamp a word": f"yesterday {NAME}",
        "stamp empty": f" {NAME}",
        "stamp of 400 digits": f"{'9' * 400} {NAME}",
        "stamp 1e999": f"1e999 {NAME}",
        "decimal comma": f"3600,0 {NAME}",
        "no UTF-8": b"3600.0 depth/\xff\xfe.png",
        "NUL in the name": b"3600.0 depth/\0.png",
    }
    for name, told in words.items():
        yield Break(name, line(1, told), REFUSED, here, SURE, quick=name in ("stamp nan", "no UTF-8"))
    either = {
        "stamp negative": f"-5 {NAME}",
        "stamp 1e300": f"1e300 {NAME}",
        "stamp with underscore": f"3_600 {NAME}",
        "stamp in Arabic digits": f"\u0663\u0666 {NAME}",
        "stamp hexadecimal": f"0x10 {NAME}",
        "three words": f"3600.0 {NAME} more",
    }
    for name, told in either.items():
        yield Break(name, line(1, told))
    yield Break("stamps fall", stamps(lambda n: 3600 - n))
    yield Break("stamps all the same", stamps(lambda n: 3600))
    yield Break("stamps huge", stamps(lambda n: f"{n + 1}e18"))
    yield Break("stamps tiny", stamps(lambda n: f"{n}e-12"))
    yield Break("one frame", content(lambda good: b"\n".join(good.splitlines()[:3]) + b"\n"))
    yield Break("one file in 500 lines", content("".join(f"{n}.5 {NAME}\n" for n in range(500)).encode()))
    for name, told in encodings(b"3600.0 depth/000000.png\n3600.1 depth/000001.png\n3600.2 depth/000002.png\n"):
        right = {"BOM": ACCEPTED, "CRLF": ACCEPTED, "Latin-1": REFUSED, "surrogates": REFUSED}.get(name, EITHER)
        yield Break(name, content(told), right, here, ("convert",) if right is ACCEPTED else SURE, quick=name == "BOM")


def names() -> Iterator[Break]:
    """Names of files that are not there, not files, or not inside."""
    lost = {
        "missing file": "depth/999999.png",
        "a name of 5 kB": "depth/" + "x" * 5000 + ".png",
        "a path of 4 kB": "a/" * 2000 + "x.png",
        "escape codes": "depth/\x1b[31mred\x1b[0m\x07.png",
        "turned writing": "depth/\u202egnp.png",
        "the folder itself": "depth",
        "a dot": ".",
    }
    for name, told in lost.items():
        yield Break(
            name,
            line(0, f"3600.0 {told}"),
            REFUSED,
            ("depth.txt", "depth", "999999.png", "xxx", "a/a", "in rec;"),
            WHOLE,
            SKIPPING,
            quick=name == "escape codes",
        )
    out = {
        "/etc/passwd": "/etc/passwd",
        "a good picture outside": "../outside/good_depth",
        "far outside": "../" * 30 + "etc/passwd",
        "in and out": "depth/../../outside/good_depth",
        "/dev/zero": "/dev/zero",
        "/dev/stdin": "/dev/stdin",
        "/proc/self/mem": "/proc/self/mem",
    }
    for name, told in out.items():
        yield Break(
            f"names {name}",
            line(0, f"3600.0 {told}"),
            REFUSED,
            ("depth.txt", "passwd", "good_depth", "/dev", "/proc"),
            WHOLE,
            SKIPPING,
            quick=name == "/etc/passwd",
        )
    odd = {
        "a FIFO": fifo,
        "a folder": folder,
        "a socket": unix_socket,
        "a link to /dev/zero": link("/dev/zero"),
        "a link in a loop": link("odd.png"),
        "a link out": link("../../outside/good_depth"),
        "a link to /etc/passwd": link("/etc/passwd"),
        "a link to nothing": link("nothing"),
    }
    for name, put in odd.items():
        yield Break(
            f"names {name}", named(put), REFUSED, ("odd.png", "depth.txt"), WHOLE, SKIPPING, quick=name == "a FIFO"
        )
    yield Break("names a link inside", named(link("000001.png")), ACCEPTED, (), ("convert",))
    yield Break("depth/ is a link out", _folder_out, REFUSED, ("depth",), WHOLE, SKIPPING)


def _folder_out(rec: Path) -> None:
    (rec / "depth").rename(rec.parent / "outside" / "depth")
    (rec / "depth").symlink_to("../outside/depth")


def cases() -> Iterator[Case]:
    yield from crossed("depth.txt", [*lines(), *names()], OTHERS)
    odd = [
        Break(name, lambda rec, put=put: put(rec / "depth.txt"), REFUSED, ("depth.txt", "rec"), quick=name == "a FIFO")
        for name, put in NO_FILE.items()
    ]  # type: ignore[misc]
    yield from crossed("depth.txt is", odd, DEPTH_READERS)
