"""System packages: installed where nobody has to be asked, else one line with the command, before any download."""

import sys
from types import SimpleNamespace

import pytest

from fusion.commands.terminal import system_libraries
from tools import system_packages


def lacking(*libraries: str):
    """A loader of libraries that does not find some."""

    def load(name: str):
        if name in libraries:
            raise OSError(f"{name}: cannot open shared object file")

    return load


@pytest.fixture
def machine(monkeypatch):
    """A Debian that lacks libGL, with the given user and programs; returns the commands that were run."""

    def make(user: int, programs: dict[str, int]) -> list[list[str]]:
        """`programs`: name to exit status."""
        ran: list[list[str]] = []

        def run(command, **_):
            ran.append(command)
            failing = [status for name, status in programs.items() if name in command and status]
            return SimpleNamespace(returncode=max(failing, default=0), stdout="E: no network\n")

        monkeypatch.setattr(system_libraries.ctypes, "CDLL", lacking("libGL.so.1"))
        for module in (system_packages, system_libraries):
            monkeypatch.setattr(module.os, "geteuid", lambda: user)
            monkeypatch.setattr(module.shutil, "which", lambda name: name if name in programs else None)
        monkeypatch.setattr(system_packages.subprocess, "run", run)
        return ran

    return make


def test_root_installs(machine, capsys):
    ran = machine(0, {"apt-get": 0})
    assert system_packages.main([]) == 0
    assert [command[-1] for command in ran] == ["update", "libgl1"]
    assert "libgl1" in capsys.readouterr().out


def test_sudo_that_asks_nothing_installs(machine):
    ran = machine(1000, {"apt-get": 0, "sudo": 0})
    assert system_packages.main([]) == 0
    assert ran[0] == ["sudo", "-n", "true"]
    assert all(command[:2] == ["sudo", "-n"] for command in ran)
    assert ran[-1][-1] == "libgl1"


@pytest.mark.parametrize(("programs", "starts"), [({}, "su -c 'apt-get"), ({"sudo": 1}, "sudo sh -c 'apt-get")])
def test_others_are_told_the_command_in_one_line(machine, capsys, programs, starts):
    ran = machine(1000, {"apt-get": 0, **programs})
    assert system_packages.main([]) == 1
    assert not [command for command in ran if "apt-get" in command]
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert starts in line and "libGL.so.1" in line
    assert line.rstrip().endswith("libgl1'")


def test_a_failing_apt_is_one_line(machine, capsys):
    machine(0, {"apt-get": 100})
    assert system_packages.main([]) == 1
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "E: no network" in line


def test_other_systems_are_told_the_libraries(machine, capsys):
    machine(0, {})
    assert system_packages.main([]) == 1
    assert "libGL.so.1" in capsys.readouterr().err


def test_python_without_ensurepip_gets_its_package(machine, monkeypatch):
    ran = machine(0, {"apt-get": 0})
    monkeypatch.setattr(system_packages.importlib.util, "find_spec", lambda name: None)
    assert system_packages.main([]) == 0
    assert ran[-1][-1] == f"python3.{sys.version_info.minor}-venv"


@pytest.mark.parametrize(("browser", "asked"), [({}, True), ({"google-chrome": 0}, False)])
def test_a_browser_only_where_it_is_wanted(machine, browser, asked):
    ran = machine(0, {"apt-get": 0, **browser})
    assert system_packages.main(["--browser"]) == 0
    assert ("chromium" in ran[-1]) == asked
    ran.clear()
    assert system_packages.main([]) == 0
    assert "chromium" not in ran[-1]


def test_nothing_is_run_where_nothing_is_missing(machine, monkeypatch, capsys):
    ran = machine(1000, {"chromium": 0})
    monkeypatch.setattr(system_libraries.ctypes, "CDLL", lacking())
    assert system_packages.main(["--browser"]) == 0
    assert not ran
    assert capsys.readouterr() == ("", "")
