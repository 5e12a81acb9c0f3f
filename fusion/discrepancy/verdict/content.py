"""The content of `verdict.json` (`fusion-verdict/1`) as one value. Fields are the keys of the file."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from fusion.discrepancy.extrapolation import ExtrapolatedFit
from fusion.discrepancy.held_out import HeldOutFit
from fusion.discrepancy.inference.camera_file import FileError
from fusion.discrepancy.inference.identifiability import Identifiability
from fusion.discrepancy.observe.outliers import OutlyingRecording
from fusion.discrepancy.observe.single_pixels import SinglePixel
from fusion.discrepancy.planning.plan import Shows
from fusion.discrepancy.verdict.claim import Claim, Names

FORMAT: Literal["fusion-verdict/1"] = "fusion-verdict/1"
MODEL, SIMULATION = "model", "simulation"  # what recordings are held against


class LooseSize(Struct, frozen=True, kw_only=True):
    """An error of places or recordings that follows no law."""

    value: float
    unit: str


class Fit(Struct, frozen=True, kw_only=True):
    """What was fitted, and how well it predicts what was not."""

    heldout: HeldOutFit
    extrapolation: tuple[ExtrapolatedFit, ...]
    scatter: LooseSize
    drift: LooseSize
    frames_fitted: int
    frames_heldout: int


class UpperLimit(Struct, frozen=True, kw_only=True):
    """How large an effect that was not found could still be."""

    effect: str
    parameter: str
    upper: float
    unit: str
    confidence: float


class Unexplained(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What the extended model leaves beyond noise."""

    rms_m: float
    recordings: Annotated[Names, Meta(description="the worst first")]
    chi2_per_dof: float
    suggested_rms_m: Annotated[float | None, Meta(description="what the model with all that is likely leaves")] = None


class Nuisances(Struct, frozen=True, kw_only=True):
    """How much worse than stated the setting of the recordings is."""

    pose_factor: float
    shape_rms_m: float
    mesh_scale: float
    mesh_off_m: float
    drift_rms_m: float
    camera_file: FileError


class SelfMadeReference(Struct, frozen=True, kw_only=True):
    """What a mesh that was reconstructed from such recordings hides."""

    mesh: str = "reconstruction"
    hides: Names
    text: str


class Verdict(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What an explanation says: the content of `verdict.json`."""

    format: Literal["fusion-verdict/1"]
    nothing_missing: bool
    missing: Annotated[tuple[Claim, ...], Meta(description="established, the largest gain first")]
    fit: Fit
    indicated: Annotated[tuple[Claim, ...], Meta(description="likely and not established")]
    limits: Annotated[tuple[UpperLimit, ...], Meta(description="what was not found, and how large it could still be")]
    invisible: Annotated[Names, Meta(description="what this data cannot show at all")]
    identifiability: tuple[Identifiability, ...]
    would_show: Annotated[tuple[Shows, ...], Meta(description="recordings that show what is invisible here")]
    unexplained: Unexplained
    nuisances: Nuisances
    nuisances_instead: Annotated[Nuisances | None, Meta(description="that may be all there is to it")] = None
    outliers: Annotated[tuple[OutlyingRecording, ...], Meta(description="with something that is not in their mesh")]
    single_pixels: Annotated[tuple[SinglePixel, ...], Meta(description="that stand alone in most recordings")] = ()
    repeats: Annotated[tuple[Names, ...], Meta(description="names of the recordings of each placement with several")]
    reference: SelfMadeReference | None = None
    against: Annotated[str, Meta(description='"simulation" where another simulator stands for the model')] = MODEL
    headline: Annotated[str, Meta(description="the whole in one sentence")] = ""
    seconds: Annotated[dict[str, float] | None, Meta(description="of each stage, where a command followed it")] = None
