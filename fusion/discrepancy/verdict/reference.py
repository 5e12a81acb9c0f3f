"""What a reference that these recordings made themselves hides: what is wrong in the same way from every side."""

from collections.abc import Sequence
from dataclasses import replace

from fusion.discrepancy.inference.identifiability import stands_out
from fusion.discrepancy.inference.tile_covariance import TileCovariance, covariance_of
from fusion.discrepancy.naming.search.candidates import Candidate
from fusion.discrepancy.observe.observations import Observations
from fusion.discrepancy.verdict.content import SelfMadeReference


def reference_of(
    observations: Observations, covariance: TileCovariance, candidates: Sequence[Candidate]
) -> SelfMadeReference | None:
    """What the verdict says of a mesh that was reconstructed from such recordings; None where the mesh is another."""
    if not any(getattr(patch.block.stage, "reconstructed", False) for patch in observations.patches):
        return None
    exact = covariance_of(_as_if_exact(observations))
    seen = {candidate.name for candidate in candidates if stands_out(candidate)}
    could = [c.name for c in candidates if stands_out(replace(c, white=exact.whiten(c.columns)))]
    hides = tuple(name for name in dict.fromkeys(could) if name not in seen)
    text = (
        "The reference was reconstructed from such recordings: what is wrong in the same way from every side is in the "
        "mesh too. At their usual size these would stand out before an exact mesh, and do not here: "
        f"{', '.join(hides) or 'none of the catalogue'}."
    )
    return SelfMadeReference(hides=hides, text=text)


def _as_if_exact(observations: Observations) -> Observations:
    """The same with a mesh that is nowhere off."""
    patches = []
    for patch in observations.patches:
        stage = replace(patch.block.stage, mesh_sigma_m=0.0)
        patches.append(replace(patch, block=replace(patch.block, stage=stage)))
    return replace(observations, patches=tuple(patches))
