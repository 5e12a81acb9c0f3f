"""`auto` takes the first card that passes its check and is faster, else the processor."""

import subprocess
from types import SimpleNamespace

import pytest

from fusion.compute.cards import self_check
from fusion.compute.cards.best_card import best_card


@pytest.mark.parametrize(
    ("answers", "taken"),
    [
        ({"cuda": "3.5\n", "vulkan": "9.0\n"}, "cuda"),  # the first that passes
        ({"cuda": None, "vulkan": "9.0\n"}, "vulkan"),  # no such card, or it computes wrong
        ({"cuda": None, "vulkan": "0.1\n"}, ""),  # a software device
        ({"cuda": None, "vulkan": None}, ""),
    ],
)
def test_the_first_card_that_passes_is_taken(answers, taken, monkeypatch):
    def answered(command, env, **_):
        told = answers[env["FUSION_DEVICE"]]
        if told is None:
            raise subprocess.CalledProcessError(1, command)
        return SimpleNamespace(stdout=f"a driver's own words\n{told}")

    monkeypatch.setattr(subprocess, "run", answered)
    assert best_card() == taken


def test_a_driver_that_hangs_is_no_card(monkeypatch):
    def hangs(command, timeout, **_):
        raise subprocess.TimeoutExpired(command, timeout)

    monkeypatch.setattr(subprocess, "run", hangs)
    assert best_card() == ""


def test_a_device_beside_itself_is_as_fast(monkeypatch):
    monkeypatch.setattr(self_check, "init", lambda **_: None)  # this process stays as it is
    assert 0.1 < self_check.times_as_fast() < 10  # others use the machine too
