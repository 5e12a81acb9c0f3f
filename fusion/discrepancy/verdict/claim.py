"""A claim of the verdict: which effect, how large, where, and how sure. Fields are the keys of `verdict.json`."""

from collections.abc import Iterator
from typing import Annotated

from msgspec import UNSET, Meta, Struct, UnsetType

from fusion.discrepancy.unknown.frame import LawFrame
from fusion.discrepancy.unknown.nearest import NearestEffect
from fusion.sensor.where import BoundFields

Names = tuple[str, ...]


class ClaimedNumber(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A fitted parameter; of a list the first entry, and all entries beside it."""

    value: float
    std: Annotated[float | None, Meta(description="standard deviation; null: not known")]
    unit: str
    determined: Annotated[bool, Meta(description="false: the data leave it open")] | None = None
    all: tuple[float, ...] | None = None
    all_std: tuple[float | None, ...] | None = None
    all_determined: tuple[bool, ...] | None = None

    def each(self) -> Iterator[tuple[float, float | None, bool]]:
        """Value, deviation, and whether it is determined: of every entry of a list, else of the one number."""
        values, stds = self.all or (self.value,), self.all_std or (self.std,)
        return zip(values, stds, self.all_determined or (self.determined is not False,), strict=True)


class Size(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """How much a claim changes of what one sees: of the depth, of its noise, or of the share of missing values."""

    rms_m: float | None = None
    peak_m: float | None = None
    noise_before_m: float | None = None
    noise_after_m: float | None = None
    missing_before: float | None = None
    missing_after: float | None = None


class Where(Struct, frozen=True, kw_only=True):
    """What a law depends on, and where it was seen."""

    variables: Annotated[Names, Meta(description="what the law depends on, in its native unit")]
    region: Annotated[tuple[BoundFields, ...], Meta(description="where it is; empty: everywhere")] = ()
    recordings: Annotated[Names | None, Meta(description="names of folders; null: all")] = None
    frames: Annotated[
        tuple[int, int] | None, Meta(description="first and last of each of these recordings, from 0; null: all")
    ] = None
    mask: Annotated[str | None, Meta(description="picture of where in the image the data tell of it")] = None
    text: Annotated[str, Meta(description="one sentence for a person")]


class ClaimEvidence(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """How sure a claim is."""

    heldout_gain: Annotated[float, Meta(description="drop of the held-out chi2 over the chi2 before")]
    false_alarm_probability: float
    visible_share: Annotated[float, Meta(description="of the signature's norm, that survives the nuisances")]
    posterior: float | None = None


class LawForm(Struct, frozen=True, kw_only=True):
    """The form of a law that has no name in the catalogue."""

    form: str
    simple: bool
    added_as: str = "tabulated"


class NextRecording(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The recording that parts a claim from its look-alikes; `sigma` is None where nothing on the menu does."""

    text: str
    recording: str
    sigma: float | None
    switch: bool
    minutes: float | None = None
    parts: Names
    leaves: Names


class Claim(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What is missing in a model: established, or likely."""

    effect: Annotated[str, Meta(description='name in the catalogue, or "unknown"')]
    parameters: dict[str, ClaimedNumber]
    channel: Annotated[str, Meta(description='"bias", "noise" or "dropout"')]
    size: Size
    where: Where
    evidence: ClaimEvidence
    indistinguishable_from: Annotated[Names, Meta(description="effects that look the same in this data")]
    only_together: Annotated[Names, Meta(description="look-alikes that are one only together")] = ()
    zero_of: Annotated[Names, Meta(description="look-alikes that are claimed too, with their zero elsewhere")] = ()
    record_next: Annotated[str, Meta(description="the recording that would tell them apart, or empty")]
    law: LawForm | None = None
    frame: LawFrame | None = None
    nearest: NearestEffect | UnsetType | None = UNSET
    next: NextRecording | None = None

    @property
    def unknown(self) -> bool:
        """True where no effect of the catalogue explains it."""
        return self.effect == "unknown"
