"""Plan: for every claim with look-alikes, and every effect that does not show, the recording to make next."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fusion.discrepancy.look import Look
from fusion.discrepancy.naming.candidates import Candidate
from fusion.discrepancy.planning.menu import MENU, Choice
from fusion.discrepancy.planning.planned import Planned, planned
from fusion.discrepancy.planning.separation import Claimed, Parting, Proposal, best, parting, visible_in
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.forms import SMALL, forms_of
from fusion.sensor.sensor import Sensor

SHOWN = 5.0  # standard deviations
# what the tiles of the menu do not show, by what an effect depends on
OTHERWISE = (
    ("velocity", "move the camera or the target at two known speeds, once each way"),
    ("table_angle", "an object on the turntable, a full turn each way, then put down at another place of the plate"),
    (
        "edge",
        "a straight board before a wall, its edge slanted by a few degrees, many frames: edges",
    ),
    ("ambient", "lamp switch: the same scene with the room dark and with a lamp or the sun on it"),
    ("temperature", "warm-up switch: the same scene cold and warm, with the temperature in telemetry.csv"),
    ("amplitude", "patches of black, grey and white paper, with infrared images recorded"),
)


@dataclass(frozen=True)
class Next:
    """What to record to tell a claim from its look-alikes.

    Attributes:
        proposal: the recording and the least separation that it brings; None where nothing of the menu helps.
        parted, left: names that it tells from the claim, and names that stay.
    """

    proposal: Proposal | None
    parted: tuple[str, ...]
    left: tuple[str, ...]


@dataclass(frozen=True)
class Shows:
    """A recording in which an effect of usual size would show, and by how many standard deviations; None: by words."""

    effect: str
    text: str
    recording: str
    sigma: float | None


class Plans:
    """The menu as this sensor would see it; seen when first asked for."""

    def __init__(self, sensor: Sensor, looks: Sequence[Look]) -> None:
        self._sensor, self._looks = sensor, looks

    @cached_property
    def all(self) -> tuple[Planned, ...]:
        made = (planned(choice, self._sensor, self._looks) for choice in MENU)
        return tuple(plan for plan in made if plan is not None)

    def to_part(self, claimed: Claimed, rivals: dict[str, list[Candidate]]) -> Next:
        """The recording that parts a claim from most of its rivals, forms by name, as well as one can."""
        table = {name: [(p.choice, parting(claimed, forms, p)) for p in self.all] for name, forms in rivals.items()}
        could = [name for name, row in table.items() if best(row) is not None]
        # of several rivals the hardest counts
        together = [
            (plan.choice, max((table[name][k][1] for name in could), key=lambda p: p.cosine))
            for k, plan in enumerate(self.all)
            if could
        ]
        proposal = best(together) or best([item for name in could for item in table[name]])
        if proposal is None:
            return Next(None, (), tuple(rivals))
        told = [name for name in could if best([i for i in table[name] if i[0] is proposal.choice]) is not None]
        return Next(proposal, tuple(told), tuple(name for name in rivals if name not in told))

    def to_show(self, names: Sequence[str]) -> list[Shows]:
        """For each effect that does not show here, where it would."""
        kinds = {kind.name: kind for kind in EFFECTS}
        return [shown for name in names if (shown := self._shows(kinds[name])) is not None]

    def _shows(self, kind: type[Effect]) -> Shows | None:
        sigmas: list[tuple[Choice, Parting]] = []
        if kind.changes("bias"):
            for plan in self.all:
                sizes = [visible_in(plan, effect) / SMALL for effect in self._usual(kind)]
                sigmas.append((plan.choice, Parting(max(sizes, default=0.0), 0.0)))
        proposal = best([(choice, seen) for choice, seen in sigmas if seen.sigma >= SHOWN])
        if proposal is not None:
            return Shows(kind.name, proposal.choice.text, proposal.choice.name, proposal.sigma)
        words = next((text for variable, text in OTHERWISE if variable in kind.variables), None)
        return None if words is None else Shows(kind.name, words, "", None)

    def _usual(self, kind: type[Effect]) -> Iterator[Effect]:
        """Instances that are a small known share of the usual size."""
        for form in forms_of(kind, self._looks[0].view.camera.shape)[:3]:
            yield from form.instances()


def rivals_of(names: Sequence[str], candidates: Sequence[Candidate]) -> dict[str, list[Candidate]]:
    """Forms of each name that act everywhere and change anything."""
    out: dict[str, list[Candidate]] = {}
    for candidate in candidates:
        if candidate.name in names and candidate.form.atoms and not candidate.where and np.any(candidate.white):
            out.setdefault(candidate.name, []).append(candidate)
    return out
