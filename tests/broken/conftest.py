"""What tests of the corpus share."""

import pytest

from broken import bases


@pytest.fixture(scope="session")
def good_inputs(tmp_path_factory):
    """The good recordings and files that cases break, made once."""
    folder = tmp_path_factory.mktemp("bases")
    bases.prepare(folder)
    return folder
