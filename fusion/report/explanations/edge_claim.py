"""The part of the page about a claim at depth edges: the profile across them, recorded and as models have it."""

import numpy as np
from numpy.typing import NDArray

from fusion.discrepancy.edges.places import EdgePlaces
from fusion.discrepancy.edges.steps import places_of
from fusion.discrepancy.explain import Explanation
from fusion.discrepancy.verdict.claim import Claim
from fusion.report.explanations.claims import lead, parameters_table, questions
from fusion.report.kit.page import Figure, Section
from fusion.report.kit.palette import BLUE, GREY, ORANGE, new_figure, styled, to_svg
from fusion.sensor.words.in_words import plain

PANELS = (
    "depth, from near (0) to far (1)",
    "between both sides\n(1/4: halfway)",
    "scatter from frame to frame\n[squared gap]",
)
LEAST_SHOWN = 0.05  # of what lies between, and of scatter: less is noise


def is_of(channel: str, found: Explanation, claim: Claim) -> bool:
    """True for a claim of a channel that depths of tiles do not show: they keep clear of edges, and have no light."""
    return any(step.effect is not None and step.effect.name == claim.effect for step in found.channels.of(channel))


def edge_section(found: Explanation, number: int, claim: Claim) -> Section:
    """Everything about one claim at edges."""
    title = f"{'Also missing' if number else 'Missing'}: {plain(claim.effect)} (depth edges)"
    places = places_of(found.named.observations)
    figures = () if places is None else (_figure(found, places, f"claim-{number}", plain(claim.effect)),)
    return Section(title, lead(claim), figures, html=parameters_table(claim) + questions(claim))


def _figure(found: Explanation, places: EdgePlaces, name: str, effect: str) -> Figure:
    given, better = places.under(found.before.sensor), places.under(found.channels.sensor)
    at = np.concatenate([rims.at for rims in places.rims])
    with styled():
        figure = new_figure(11.0, 3.6)
        for row, (ax, label) in enumerate(zip(figure.subplots(1, len(PANELS)), PANELS, strict=True)):
            ax.plot(*_mean(at, given.profiles[row]), color=ORANGE, label="without it")
            ax.plot(*_mean(at, better.profiles[row]), color=BLUE, label="with it")
            ax.plot(*_mean(at, places.recorded[row]), "o", color=GREY, markersize=3.5, label="recorded")
            ax.set_xlabel("distance to the edge [px]")
            ax.set_ylabel(label)
            ax.set_ylim(top=max(ax.get_ylim()[1], LEAST_SHOWN))
            if row == 0:
                ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0.1)
        return Figure(
            "What is recorded across a depth edge",
            to_svg(figure, name),
            f"Profile across depth edges with and without {effect}.",
            f"Means over {len(places.rims)} placements and all edges, the near thing on the left; each model "
            "with the edges where poses, camera file and outline let it fit best. Left: the depth. Middle: how much "
            "pixels lie between both sides, wherever the edge is. Right: how much they change from frame to frame.",
        )


def _mean(at: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distances that occur, rising, and the mean of the values (n,) at each."""
    where, number = np.unique(at, return_inverse=True)
    return where, np.bincount(number, weights=values) / np.bincount(number)
