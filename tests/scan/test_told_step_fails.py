"""Where a step that was told leads nowhere, the message names it."""

import numpy as np
import pytest

from fusion.errors import TrackingError
from fusion.scan.finding import pair_fit
from fusion.turntable.views import Region


def test_a_step_that_leads_nowhere_is_named(monkeypatch):
    def nowhere(*_):
        raise TrackingError("the object hardly turns", do="use `fusion reconstruct`")

    monkeypatch.setattr(pair_fit, "estimate_motion", nowhere)
    region = Region(np.zeros(3), np.ones(3))
    with pytest.raises(TrackingError, match=r"try it without --step.*use `fusion reconstruct`"):
        pair_fit._motion([], region, pair_fit._Known(np.zeros(3), None, False))
    with pytest.raises(TrackingError) as alone:
        pair_fit._motion([], region, pair_fit._Known(None, None, True))
    assert "--step" not in str(alone.value)
