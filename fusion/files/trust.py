"""How far the process trusts what it reads."""

from fusion.files.inside import follow_links
from fusion.files.limits import allow


def trust(gigabytes: float, links: bool) -> None:
    """From now on: one input may take this much [GB]; names may lead out of their folder, or not."""
    allow(gigabytes)
    follow_links(links)
