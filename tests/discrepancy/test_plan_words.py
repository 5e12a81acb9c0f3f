"""What to record next is said in whole sentences."""

import pytest

from fusion.discrepancy.planning.menu import MENU
from fusion.discrepancy.planning.plan import OTHERWISE
from fusion.report.explanations.visibility import advised

TEXTS = [choice.text for choice in MENU] + [text for _, text in OTHERWISE]


@pytest.mark.parametrize("text", TEXTS)
def test_a_recording_is_a_name_and_a_thing(text):
    """Not an order: "Record move the camera" stood on the page."""
    name, _, what = text.partition(": ")
    assert what and ":" not in what and len(name.split()) <= 3
    assert what.split()[0] in ("a", "an", "the", "one", "two", "patches")
    assert advised(text) == f"What would show it: {what} ({name})."
