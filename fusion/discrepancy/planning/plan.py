"""Plan: for every claim with look-alikes, and every effect that does not show, the recording to make next."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fusion.discrepancy.decisions import DETECTED
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.planning.menu import MENU, QUICKEST, Choice
from fusion.discrepancy.planning.planned import MenuViews, Planned, planned
from fusion.discrepancy.planning.separation import Claimed, Parting, Proposal, best, parting, visible_in
from fusion.recording.ahead import side_by_side
from fusion.sensor.effect import Effect
from fusion.sensor.effects import EFFECTS
from fusion.sensor.forms import SMALL, forms_of
from fusion.sensor.sensor import Sensor

# what the tiles of the menu do not show, by what an effect depends on
OTHERWISE = (
    ("velocity", "two speeds: the camera or the target moving at two known speeds, once each way"),
    (
        "table_angle",
        "turntable: an object on the turntable, a full turn each way, then put down at another place of the plate",
    ),
    ("edge", "edges: a straight board before a wall, two opposite edges slanted by a few degrees, many frames"),
    ("ambient", "lamp switch: the same scene with the room dark and with a lamp or the sun on it"),
    ("temperature", "warm-up switch: the same scene cold and warm, with the temperature in telemetry.csv"),
    ("amplitude", "infrared: patches of black, grey and white paper, with infrared images recorded"),
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
    recording: str
    text: str
    sigma: float | None


class Plans:
    """The menu as this sensor would see it; seen when first asked for."""

    def __init__(self, sensor: Sensor, blocks: Sequence[FrameBlock]) -> None:
        self._sensor, self._blocks_of = sensor, blocks
        self._views = MenuViews(blocks[0].view.camera, sensor)
        self._made: dict[str, Planned | None] = {}

    @cached_property
    def all(self) -> tuple[Planned, ...]:
        plans = tuple(plan for plan in map(self._of, MENU) if plan is not None)
        side_by_side(lambda plan: plan.covariance, plans)
        return plans

    def _of(self, choice: Choice) -> Planned | None:
        if choice.name not in self._made:
            self._made[choice.name] = planned(choice, self._blocks_of, self._views)
        return self._made[choice.name]

    @cached_property
    def _glimpses(self) -> dict[str, Planned | None]:
        """The menu in small images: enough to see where an effect changes nothing at all, and a tenth of the time."""
        views = self._views.small()
        return {choice.name: planned(choice, self._blocks_of, views) for choice in MENU}

    def to_part(self, claimed: Claimed, rivals: dict[str, list[Candidate]], own: Sequence[Candidate] = ()) -> Next:
        """The recording that parts a claim and its rivals, whichever of them is true, as well as one can.

        Args:
            rivals: forms by name.
            own: forms of the claim, where a rival may be the true one.
        """
        pairs = {(name, k): self._parted(pair, forms) for name, k, pair, forms in _pairs(claimed, rivals, own)}
        could = {key: row for key, row in pairs.items() if best(row) is not None}
        # of several pairs the hardest counts
        together = [
            (plan.choice, max((row[k][1] for row in could.values()), key=lambda p: p.cosine))
            for k, plan in enumerate(self.all)
            if could
        ]
        proposal = best(together) or best([item for row in could.values() for item in row])
        if proposal is None:
            return Next(None, (), tuple(rivals))
        told = [
            name
            for name in rivals
            if (name, 0) in could and best([i for i in could[name, 0] if i[0] is proposal.choice]) is not None
        ]
        return Next(proposal, tuple(told), tuple(name for name in rivals if name not in told))

    def _parted(self, claimed: Claimed, forms: Sequence[Candidate]) -> list[tuple[Choice, Parting]]:
        return [(plan.choice, parting(claimed, forms, plan)) for plan in self.all]

    def to_show(self, names: Sequence[str]) -> list[Shows]:
        """For each effect that does not show here, where it would: the quickest recording, switches first."""
        kinds = {kind.name: kind for kind in EFFECTS}
        shown = [self._shows(kinds[name]) for name in names]
        return [shows for shows in shown if shows is not None]

    def _shows(self, kind: type[Effect]) -> Shows | None:
        usual = list(self._usual(kind)) if kind.changes("bias") else []
        for choice in QUICKEST if usual else ():
            glimpse = self._glimpses[choice.name]
            plan = self._of(choice) if glimpse is None or glimpse.changes_with(usual) else None
            sigma = 0.0 if plan is None else max(visible_in(plan, effect) / SMALL for effect in usual)
            if sigma >= DETECTED:
                return Shows(kind.name, choice.name, choice.text, sigma)
        words = next((text for variable, text in OTHERWISE if variable in kind.variables), None)
        return None if words is None else Shows(kind.name, "", words, None)

    def _usual(self, kind: type[Effect]) -> Iterator[Effect]:
        """Instances that are a small known share of the usual size."""
        for form in forms_of(kind, self._blocks_of[0].view.camera.shape)[:3]:
            yield from form.instances()


def _pairs(
    claimed: Claimed, rivals: dict[str, list[Candidate]], own: Sequence[Candidate]
) -> Iterator[tuple[str, int, Claimed, list[Candidate]]]:
    """Name of a rival, 0 with the claim as the true one and more with a rival, and what has to be parted."""
    for name, forms in rivals.items():
        yield name, 0, claimed, forms
    if not own:
        return
    for name, forms in rivals.items():
        true = _as(forms, claimed)
        yield name, 1, true, list(own)
        for k, other in enumerate(rivals, start=2):
            if other != name:
                yield name, k, true, rivals[other]


def _as(forms: Sequence[Candidate], claimed: Claimed) -> Claimed:
    """The rival that looks most like a claim, at the size at which it does."""
    fits = [np.linalg.lstsq(form.white, claimed.footprint, rcond=1e-9)[0] for form in forms]
    made = [form.white @ weights for form, weights in zip(forms, fits, strict=True)]
    nearest = int(np.argmin([np.linalg.norm(claimed.footprint - m) for m in made]))
    return Claimed(forms[nearest].form.combined(list(fits[nearest])), made[nearest])


def rivals_of(names: Sequence[str], candidates: Sequence[Candidate]) -> dict[str, list[Candidate]]:
    """Forms of each name that act everywhere and change anything."""
    out: dict[str, list[Candidate]] = {}
    for candidate in candidates:
        if candidate.name in names and candidate.form.atoms and not candidate.where and np.any(candidate.white):
            out.setdefault(candidate.name, []).append(candidate)
    return out
