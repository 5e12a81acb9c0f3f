"""Numbers of the lens report as people write them."""

import pytest

from fusion.report.calibrations.lens_figures import brief


@pytest.mark.parametrize(
    ("value", "text"), [(0.0431, "0.043"), (6.158, "6.2"), (31.3, "31"), (415.5, "420"), (1193.5, "1200"), (0.0, "0")]
)
def test_two_digits_and_no_powers_of_ten(value, text):
    assert brief(value) == text
