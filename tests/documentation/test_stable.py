"""What docs/stable.md promises: no public name and no command goes unnoticed."""

from pathlib import Path

import fusion
from fusion.commands.catalogue import COMMANDS

# of the versions so far; a name that goes is taken from here, with its line under Removed in CHANGELOG.md
LISTED = (Path(__file__).parent / "stable.txt").read_text(encoding="utf-8").splitlines()


def test_no_listed_name_or_command_is_gone():
    there = {*(f"fusion.{name}" for name in fusion.__all__), *(f"fusion {name}" for name in COMMANDS)}
    assert len(LISTED) > 90  # as many as the first version had, so that an empty list does not pass
    assert sorted(set(LISTED) - there) == []
