"""The layout is a law: rooms import only from rooms above them, the console starts at once, files stay small."""

import ast
import itertools
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parent.parent
SOURCES = sorted((PROJECT / "fusion").rglob("*.py"))

# each room may import from itself and from those before it
ROOMS = [
    "errors", "quantity", "progress", "files", "compute", "geometry", "recording", "devices", "mesh",
    "printing", "repeatability", "coloring", "texture", "sensor", "calibration", "evaluation", "tracking", "volume",
    "tiles", "certainty", "simulation", "turntable", "plain", "discrepancy", "results", "report", "reconstruction",
    "scan", "passes", "batch", "live", "commands",
]  # fmt: skip
ALLOWED_AT_TOP = {
    "pyproject.toml", "Makefile", "README.md", "CHANGELOG.md", "LICENSE", ".gitignore", ".ci", "docs", "fusion",
    "tools", "tests", "examples",
}  # fmt: skip
MOST = 15  # files side by side: what one look takes in
LINES, ARGUMENTS = 60, 8  # of a kernel
MIXED_TUPLES, PLAIN_DICTS = 1, 19  # in signatures, as reached
SLOW_TO_IMPORT = {"open3d", "taichi", "quadrants", "matplotlib"}


def _name(path: Path) -> str:
    return str(path.relative_to(PROJECT))


def _room(path: Path) -> str:
    parts = path.relative_to(PROJECT / "fusion").with_suffix("").parts
    return parts[0]


def _imported(path: Path) -> set[str]:
    """Full names of every `fusion` module (or name in one) that a file imports, at its top or inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{_name(path)}:{node.lineno} imports relatively"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name for name in found if name.split(".")[0] == "fusion"}


def _tracked() -> list[Path]:
    """Files that git knows or would add."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, timeout=30)
    except OSError:
        pytest.skip("git is not installed")
    if done.returncode:
        pytest.skip("not a git checkout")
    return [path for path in (PROJECT / line for line in done.stdout.splitlines()) if path.exists()]


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_a_room_imports_only_from_rooms_above(path):
    room = _room(path)
    if room == "__init__":
        assert not _imported(path), "fusion/__init__.py imports nothing"
        return
    assert room in ROOMS, f"{room} is not in the list of rooms"
    for name in _imported(path):
        other = name.split(".")[1]
        if other in ROOMS:  # else a plain name in fusion/__init__.py, such as __version__
            assert ROOMS.index(other) <= ROOMS.index(room), f"{_name(path)} imports {name}"


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_files_are_small_and_silent(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) < 300
    if _room(path) != "commands":
        calls = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
        assert not [c.lineno for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"]


def test_no_room_is_crowded():
    tools = (PROJECT / "tools").rglob("*.py")
    counts = Counter(str(path.parent.relative_to(PROJECT)) for path in [*SOURCES, *tools])
    assert not {room: count for room, count in counts.items() if count > MOST}


def test_kernels_can_be_read():
    """A kernel is short and takes few arguments; a structure (`compute/structures.py`) counts as one."""
    sizes = {}
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and "kernel" in [ast.unparse(d) for d in node.decorator_list]:
                lines, arguments = node.end_lineno - node.lineno + 1, len(node.args.args)
                sizes[f"{_name(path)}:{node.name}"] = lines, arguments
    assert len(sizes) > 40
    assert {name: size for name, size in sizes.items() if size[0] > LINES or size[1] > ARGUMENTS} == {}


def test_no_two_classes_have_one_name():
    names = [n.name for path in SOURCES for n in ast.parse(path.read_text(encoding="utf-8")).body
             if isinstance(n, ast.ClassDef) and not n.name.startswith("_")]  # fmt: skip
    assert [name for name, count in Counter(names).items() if count > 1] == []


def _annotations(path: Path) -> list[tuple[list[ast.expr], ast.expr | None]]:
    """Of each function: what its arguments are said to be, and what it gives."""
    nodes = [n for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.FunctionDef)]
    arguments = [[*n.args.posonlyargs, *n.args.args, *n.args.kwonlyargs] for n in nodes]
    return [([a.annotation for a in args if a.annotation], n.returns) for n, args in zip(nodes, arguments, strict=True)]


def _is_mixed_tuple(said: ast.expr) -> bool:
    """Whether it is a tuple of different things: a type without a name."""
    said = said.left if isinstance(said, ast.BinOp) else said
    if not isinstance(said, ast.Subscript) or ast.unparse(said.value) != "tuple":
        return False
    parts = {ast.unparse(part) for part in getattr(said.slice, "elts", [said.slice])}
    return "..." not in parts and len(parts) > 1


def test_arguments_are_types_with_names():
    """Counts that may only fall: lower them with each that gets a name."""
    both = [said for path in SOURCES for said in _annotations(path)]
    tuples = [ast.unparse(a) for arguments, _ in both for a in arguments if _is_mixed_tuple(a)]
    assert len(tuples) <= MIXED_TUPLES, tuples
    plain = sum(any("dict[str, Any]" in ast.unparse(x) for x in [*args, *([out] if out else [])]) for args, out in both)
    assert plain <= PLAIN_DICTS


def preloaded() -> set[str]:
    """What Python itself loads where it is installed."""
    program = "import sys; print(*{name.split('.')[0] for name in sys.modules})"
    return set(subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout.split())


def test_help_loads_nothing_slow():
    """Neither the overview nor the help of any command may load the large libraries."""
    program = """
import contextlib, io, sys
from fusion.commands.catalogue import COMMANDS
from fusion.commands.main import main
for arguments in [["--help"], *([name, "--help"] for name in COMMANDS)]:
    with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
        main(arguments)
    print(arguments[0], *sorted({name.split(".")[0] for name in sys.modules}))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    overview = set(done.stdout.splitlines()[0].split()[1:])
    assert overview - sys.stdlib_module_names <= {"fusion", "sitecustomize"} | preloaded()
    for line in done.stdout.splitlines():
        command, *loaded = line.split()
        assert not SLOW_TO_IMPORT & set(loaded), f"{command} --help loads {SLOW_TO_IMPORT & set(loaded)}"


def test_top_level_holds_what_it_should():
    assert {path.relative_to(PROJECT).parts[0] for path in _tracked()} == ALLOWED_AT_TOP


def test_no_large_file_is_tracked():
    # recordings and results belong elsewhere; 2 MB is far above any source, fixture or picture of ours
    assert not [_name(path) for path in _tracked() if path.is_file() and path.stat().st_size > 2_000_000]


def test_test_files_have_names_of_their_own():
    """pytest imports them by name alone: two of one name stop a whole run, and no narrow one."""
    names = sorted(path.name for path in (PROJECT / "tests").rglob("test_*.py"))
    assert [a for a, b in itertools.pairwise(names) if a == b] == []
