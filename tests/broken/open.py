"""Cases that break the rule and are not mended yet, each with the reason; this list should be empty.

The tests demand that each of them still fails: an entry that is mended must go.
"""

OPEN: dict[str, str] = {}
