"""A library that cannot be loaded is one line with the command that helps, in every command."""

import subprocess
import sys
from types import SimpleNamespace

import pytest

from fusion.commands import main as program
from fusion.commands.terminal import system_libraries
from fusion.commands.terminal.failed_import import failed_import

NO_FILE = "cannot open shared object file: No such file or directory"


def lacking(*libraries: str):
    """A loader of libraries that does not find some."""

    def load(name: str):
        if name in libraries:
            raise OSError(f"{name}: cannot open shared object file")

    return load


@pytest.fixture
def told(monkeypatch, capsys, tmp_path):
    """What `fusion try` says whose run imports the module `broken` of the given source."""

    def say(source: str) -> str:
        (tmp_path / "not_whole.py").write_text(source)
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.setitem(program.COMMANDS, "try", "nothing, for a test")
        command = SimpleNamespace(EXAMPLE="", add_arguments=lambda parser: None, run=lambda options: run())
        monkeypatch.setitem(sys.modules, "fusion.commands.try", command)
        assert program.main(["try"]) == 1
        line = capsys.readouterr().err
        assert line.startswith("fusion try: ") and line.count("\n") == 1 and line.endswith("\n")
        return line

    def run() -> int:
        sys.modules.pop("not_whole", None)
        import not_whole  # noqa: F401 # type: ignore[import-not-found]

        return 0

    return say


@pytest.mark.parametrize("library", system_libraries.PACKAGES)
@pytest.mark.parametrize("kind", ["ImportError", "OSError"])
def test_a_missing_system_library_names_its_package(told, library, kind):
    line = told(f"raise {kind}('{library}: {NO_FILE}')")
    assert library in line
    assert f" {system_libraries.PACKAGES[library]}" in line.split("apt-get install")[1]


def test_every_missing_library_is_named_at_once(told, monkeypatch):
    monkeypatch.setattr(system_libraries.ctypes, "CDLL", lacking("libGL.so.1", "libEGL.so.1"))
    line = told(f"raise ImportError('libusb-1.0.so.0: {NO_FILE}')")
    for part in ("libGL.so.1", "libEGL.so.1", "libusb-1.0.so.0", "libegl1 libgl1 libusb-1.0-0"):
        assert part in line


def test_the_library_is_found_behind_other_errors(told):
    source = (
        f"try:\n    raise OSError('libX11.so.6: {NO_FILE}')\nexcept OSError as error:\n    raise ImportError('sorry')"
    )
    assert "libx11-6" in told(source)


def test_a_library_of_another_system_is_named(told):
    assert "holds libodd.so.7" in told(f"raise ImportError('libodd.so.7: {NO_FILE}')")


def test_a_missing_package_is_named(told):
    assert "package nowhere_to_be_found is not installed" in told("import nowhere_to_be_found.inside")


def test_a_package_that_does_not_fit_is_named(told):
    line = told("from numpy import no_such_thing")
    assert "numpy cannot be loaded" in line and "no_such_thing" in line and "install it again" in line


@pytest.mark.parametrize(
    "error",
    [
        ModuleNotFoundError("No module named 'fusion.nothing'", name="fusion.nothing"),
        ImportError("cannot import name 'a' from 'fusion.mesh'", name="fusion.mesh"),
        OSError(28, "No space left on device", "out"),
        FileNotFoundError(2, "No such file or directory", "libusb-1.0.so.0"),
    ],
)
def test_slips_of_our_own_and_other_refusals_are_not_taken_for_it(error):
    assert failed_import(error) is None


# a stand-in for the package whose import fails as on a machine without the library
BROKEN = f"""
import sys
from importlib.abc import MetaPathFinder
class Broken(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in ("taichi._lib.core.taichi_python", "open3d.pybind", "cv2.cv2", "cv2"):
            raise ImportError("libX11.so.6: {NO_FILE}", name=name)
sys.meta_path.insert(0, Broken())
from fusion.commands.main import main
raise SystemExit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("command", ["demo", "simulate"])
def test_the_real_libraries_fail_in_one_line(command, tmp_path):
    words = {"demo": ["demo"], "simulate": ["simulate", "patches"]}[command]
    arguments = [sys.executable, "-c", BROKEN, *words, "-o", str(tmp_path / "out")]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "libx11-6" in done.stderr, done.stderr
    assert not done.stdout
