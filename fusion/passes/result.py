"""What a merge gives back."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.trajectory import Trajectory
from fusion.mesh.mesh import Mesh
from fusion.mesh.shape import shape_of
from fusion.passes.one_pass import Pass
from fusion.results.facts import ScanFacts
from fusion.results.judgement import Judgement
from fusion.results.light import Light, level, worst_first
from fusion.volume.settings import VolumeSettings

Array = NDArray[np.float64]
# up to the first good, above the second a problem (guesses)
APART = (0.25, 0.35)  # of the distance within which surfaces are one
THROUGH = (0.01, 0.04)
OPEN = (0.02, 0.1)


@dataclass(frozen=True)
class PassPair:
    """How a pass lies to an earlier one in the merge."""

    onto: int  # index of the earlier one
    overlap: float  # share of both surfaces that lies on each other
    through: float  # share that lies where the other pass looked through
    rms: float  # distance of the surfaces where both saw [m]
    # overlap, less five times `through`; `second_score`: of the next best way to lie, -1 where there is none
    score: float
    second_score: float
    symmetric: bool  # by shape alone the next best is as good
    # correlation of the colours, and of the next best way, where they decided; else None
    colors: tuple[float, float] | None

    def values(self) -> dict[str, float | tuple[float, ...] | None]:
        """Plain values for JSON."""
        return {
            "onto": self.onto,
            "overlap_share": self.overlap,
            "through_share": self.through,
            "rms_m": self.rms,
            "score": self.score,
            "second_score": self.second_score,
            "symmetric": self.symmetric,
            "color_correlation": self.colors,
        }


@dataclass(frozen=True)
class Merged:
    """One object of several passes; its frame is that of the first pass.

    Attributes:
        mesh: the object; its scalars "passes" (how many passes show a vertex) and "passes_apart" (how far these lie
            from each other [m], NaN where one pass alone saw it).
        passes: as they were given.
        T: (k, 4, 4) from each pass's frame to the first's.
        pairs: how each pass but the first lies to an earlier one.
        trajectories: of each pass's camera about the object, in the first pass's frame.
        volume: voxel, truncation and bounds.
        told: the transforms were given, not sought.
    """

    mesh: Mesh
    passes: tuple[Pass, ...]
    T: Array
    pairs: tuple[PassPair, ...]
    trajectories: tuple[Trajectory, ...]
    volume: VolumeSettings
    told: bool = False

    def __repr__(self) -> str:
        lie = ", ".join(f"{pair.overlap:.0%} within {pair.rms * 1e3:.2f} mm rms" for pair in self.pairs)
        return f"<Merged: {len(self.passes)} passes, {lie};\n {self.mesh!r}>"

    def _repr_png_(self) -> bytes | None:
        """A picture for notebooks."""
        return self.mesh._repr_png_()

    @cached_property
    def facts(self) -> ScanFacts:
        """Every number of the mesh and the frames that terminal, page and JSON tell."""
        placed = sum(int(course.valid.sum()) for course in self.trajectories)
        frames = sum(len(course) for course in self.trajectories)
        return ScanFacts(shape_of(self.mesh, np.array([0.0, 0.0, 1.0])), frames, placed)

    @cached_property
    def judgement(self) -> Judgement:
        """What is good, doubtful or wrong about this merge, the worst first."""
        lights = [light for k in range(1, len(self.passes)) for light in self._pair_lights(k)]
        return Judgement(worst_first([*lights, self._closed(), *self._passes()]))

    def _pair_lights(self, k: int) -> list[Light]:
        pair, name = self.pairs[k - 1], self.passes[k].name
        near = max(self.passes[k].near, self.passes[pair.onto].near)
        said = f"{name} lies on {self.passes[pair.onto].name} with {pair.overlap:.0%} of the surface, "
        fit = level(pair.rms / near, APART)
        free = level(pair.through, THROUGH)
        calibrate = "Calibrate camera and depth of both passes (fusion calibrate)." if fit != "ok" else ""
        look = "Check that it is one rigid object, and that the passes are good scans." if free != "ok" else ""
        lights = [
            Light(fit, "Fit of the passes", f"{said}{pair.rms * 1e3:.2f} mm rms apart.", calibrate),
            Light(free, "Free space", f"Of {name}, {pair.through:.1%} lie where the other pass looked through.", look),
        ]
        if pair.symmetric and pair.colors is not None:
            by = f"colours decide (correlation {pair.colors[0]:.2f}, next best {pair.colors[1]:.2f})"
            lights.append(Light("ok", "Symmetry", f"By shape {name} fits in several ways; {by}."))
        return lights

    def _closed(self) -> Light:
        shape = self.facts.shape
        missing = sum(hole.area for hole in shape.holes)
        share = missing / max(missing + shape.area, 1e-12)
        judged = level(share, OPEN)
        said = "The surface is closed." if not shape.holes else f"{share:.1%} of the surface was seen in no pass."
        do = "Record another pass with these parts up: dark in the pictures." if judged != "ok" else ""
        return Light(judged, "Closed", said, do)

    def _passes(self) -> list[Light]:
        doubtful = [one for one in self.passes if one.table.get("verdict", "good") != "good"]
        said = "The passes are good scans."
        if doubtful:
            said = f"Not a good scan by itself: {', '.join(one.name for one in doubtful)}."
        do = "Look at its report.html." if doubtful else ""
        return [Light("warning" if doubtful else "ok", "Passes", said, do)]

    def merge(self) -> dict[str, Any]:
        """The content of `merge.json`."""
        worth = self.judgement.worth
        rows = []
        for k, one in enumerate(self.passes):
            pair = self.pairs[k - 1].values() if k else {}
            rows.append(
                {
                    "name": one.name,
                    "recording": str(one.recording.path),
                    "frames": len(one.frames),
                    "placed": int(one.trajectory.valid.sum()),
                    "T_merged_pass": self.T[k].tolist(),
                    **pair,
                }
            )
        square = np.square(self.mesh.scalars["passes_apart"].astype(float))
        both = np.isfinite(square)
        return {
            "frame": "the first pass's object frame: z up along its axis, its plate at z = 0",
            "passes": rows,
            "overlap_share": min(pair.overlap for pair in self.pairs),
            "rms_m": float(np.sqrt(square[both].mean())) if both.any() else None,
            "seen_twice_share": float(both.mean()),
            "second_score": max(pair.second_score for pair in self.pairs),
            "symmetric": any(pair.symmetric for pair in self.pairs),
            "transforms_told": self.told,
            "closed": not self.facts.shape.holes,
            "verdict": worth.word,
            "reasons": worth.sentences(),
        }
