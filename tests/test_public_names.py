"""`import fusion` offers its names at once, loads them late, and nothing else may take their place."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import fusion

PACKAGE = Path(fusion.__file__).parent
NAMES = [name for name in fusion.__all__ if name != "__version__"]


def run(program):
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_import_loads_nothing_but_itself():
    # test_structure.py measures its time; a module more is where that begins
    loaded = run("import sys; before = set(sys.modules); import fusion; print(*set(sys.modules) - before)").split()
    assert set(loaded) <= {"fusion", "importlib", "importlib._bootstrap", "importlib._bootstrap_external", "warnings"}


@pytest.mark.parametrize("name", NAMES)
def test_every_name_is_there_and_documented(name):
    assert getattr(fusion, name).__doc__
    assert name in dir(fusion)


def test_another_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="'fusion' has no attribute 'scan_turntables'"):
        fusion.scan_turntables  # noqa: B018


def test_no_module_takes_the_place_of_a_name():
    """`import fusion.x` sets the attribute x of the package: a function of that name would be gone."""
    modules = {path.stem for path in PACKAGE.glob("*.py")} | {path.name for path in PACKAGE.iterdir() if path.is_dir()}
    assert not modules & set(fusion.__all__)


def test_reconstruct_is_the_function_though_modules_are_imported_first():
    program = (
        "import fusion.reconstruction.pipeline as pipeline, fusion.commands.scan.reconstruct\n"
        "from fusion import reconstruct\n"
        "import fusion\n"
        "print(reconstruct is fusion.reconstruct is pipeline.reconstruct)"
    )
    assert run(program).strip() == "True"


def test_the_stub_is_read_as_python_reads_it():
    told = {}
    for node in ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            told |= {entry.asname: f"{node.module}.{entry.name}" for entry in node.names}
    assert told == {name: f"{fusion._HOME[name]}.{name}" for name in NAMES}
    assert (PACKAGE / "py.typed").exists()
