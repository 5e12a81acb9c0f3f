"""How well a mesh lies on its reference in a pose: scores of few samples, and costs of many on the exact surfaces."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.robust import MAD_TO_STD
from fusion.mesh.alignment.coarse import NEAR, score
from fusion.mesh.alignment.fit import SurfaceFit
from fusion.mesh.alignment.similarity import AS_WELL, Array, Similarity
from fusion.mesh.comparison.distances import CloudSurface, Surface
from fusion.mesh.comparison.surface_samples import SurfaceSamples, sample_surface, smooth_normals
from fusion.mesh.mesh import Mesh

_COARSE_POINTS, _FINE_POINTS = 3000, 20_000
_SEED = 3  # of what is asked: of one shape samples would else stand on each other in one of its poses alone
SCORED = 1e-4  # of the size: poses of exact shapes that belong together score alike but for this
_CLOSE = 0.2  # of what is near: more than half of a reference lies so close to what shows it alone (guess)
# variance over another that is clearly more: F at 95 % of 30 places each, as errors of scans are alike over some of an
# object (guess)
CLEARLY = 1.84
_CHANCE = 3.0  # standard deviations of the samples: what the reference's side differs by may be theirs


@dataclass(frozen=True)
class PoseScore:
    """By few samples, against stand-ins of the surfaces."""

    both: float  # mean distance of mesh and reference, no more than what counts as near each [m]
    own: float  # the mesh's part of it [m]
    # by how much the mesh's part would be more if what looks the other way, or the same way, as the reference were far
    against: float
    along: float
    covered: float  # share of the reference that lies close to the mesh


@dataclass(frozen=True)
class PoseCost:
    """By many samples: mean squared distances, no more than what counts as near, of mesh and reference [m^2]."""

    there: float
    back: float
    noise: float  # of `there`, what is near
    chance: float  # standard deviation of `back` that its samples bring

    @property
    def both(self) -> float:
        return self.there + self.back

    def as_well(self, best: "PoseCost", size: float) -> bool:
        """True where this pose is not clearly worse than the best."""
        room = (AS_WELL**2 - 1) * best.noise + (SCORED * size) ** 2
        chance = _CHANCE * float(np.hypot(self.chance, best.chance))
        return self.there - best.there <= room and self.back - best.back <= room + chance

    def maybe(self, best: "PoseCost") -> bool:
        """True where the best pose may be the better one by the chance of errors that are alike over parts of both."""
        return self.both - best.both <= (CLEARLY - 1) * best.both


@dataclass(eq=False)
class PoseJudge:
    """A mesh and its reference, sampled.

    Attributes:
        mesh, reference: in metres.
        surfaces: of both.
        size: of the reference [m].
        seen: (n, 3) points of the reference that the mesh ought to show, else its whole surface.
        inside_out: the mesh looks inwards where the reference looks outwards.
    """

    mesh: Mesh
    reference: Mesh
    surfaces: tuple[Surface, Surface]
    size: float
    seen: Array | None = None
    inside_out: bool = False
    coarse: SurfaceSamples = field(init=False)
    fine: SurfaceSamples = field(init=False)
    back: SurfaceSamples = field(init=False)
    rough: SurfaceFit = field(init=False)
    exact: SurfaceFit = field(init=False)

    def __post_init__(self) -> None:
        coarse, fine = sample_surface(self.mesh, _COARSE_POINTS), sample_surface(self.mesh, _FINE_POINTS)
        self.coarse = SurfaceSamples(coarse.points, smooth_normals(coarse))
        self.fine = SurfaceSamples(fine.points, smooth_normals(fine))
        self.back = sample_surface(self.reference, _COARSE_POINTS)
        self.rough = SurfaceFit(_quick(self.reference, self.surfaces[1]), self.size)
        self.exact = SurfaceFit(self.surfaces[1], self.size, facing=True)
        self._own = _quick(self.mesh, self.surfaces[0])
        whole = sample_surface(self.reference, _FINE_POINTS, _SEED)
        few = whole if self.seen is None or not len(self.seen) else SurfaceSamples(self.seen, None)
        self._asked = [
            SurfaceSamples(few.points[:: max(1, len(few.points) // n)], None) for n in (_COARSE_POINTS, _FINE_POINTS)
        ]

    def score(self, pose: Similarity) -> PoseScore:
        """By few samples."""
        limit = NEAR * self.size
        there, facing = self._there(pose, self.coarse, self.rough.surface)
        again = np.abs(self._back(pose, self._asked[0]))
        near = limit - np.minimum(np.abs(there), limit)
        covered = float(np.mean(again < _CLOSE * limit))
        both, own = float(score(there, again, limit)), float(score(there, np.zeros(1), limit))
        return PoseScore(both, own, float((near * (facing < 0)).mean()), float((near * (facing > 0)).mean()), covered)

    def cost(self, pose: Similarity) -> PoseCost:
        """By many samples, on the exact reference; what looks the wrong way is far."""
        limit = NEAR * self.size
        there, facing = self._there(pose, self.fine, self.surfaces[1])
        wrong = facing > 0 if self.inside_out else facing < 0
        square = np.where(wrong, limit**2, np.minimum(there**2, limit**2))
        near = square < limit**2
        back = np.minimum(self._back(pose, self._asked[1]) ** 2, limit**2)
        usual = MAD_TO_STD * float(np.median(np.sqrt(square[near]))) if near.any() else limit  # spikes are no noise
        noise = float(near.mean()) * usual**2
        return PoseCost(float(square.mean()), float(back.mean()), noise, float(back.std() / np.sqrt(len(back))))

    def refined(self, pose: Similarity, scale: bool) -> Similarity:
        """The pose after some steps of few samples on the exact reference."""
        return self.exact.run(self.coarse, pose, scale, rounds=20)[0]

    def _there(self, pose: Similarity, samples: SurfaceSamples, surface: Surface) -> tuple[Array, Array]:
        turned = None if samples.normals is None else samples.normals @ pose.rotation.T
        found = surface.closest(pose.apply(samples.points), turned)
        facing = np.zeros(1) if turned is None else np.sign(np.einsum("ij,ij->i", turned, found.normals))
        return found.distances, facing

    def _back(self, pose: Similarity, samples: SurfaceSamples) -> NDArray[np.float64]:
        return np.asarray(self._own.closest(pose.apply_inverse(samples.points), samples.normals).distances * pose.scale)


def _quick(mesh: Mesh, surface: Surface) -> Surface:
    """Stands for the surface while the pose is sought: closest points on a fine mesh are slow to find from afar."""
    if isinstance(surface, CloudSurface):
        return surface
    samples = sample_surface(mesh, _FINE_POINTS)
    normals = None if samples.normals is None else samples.normals.astype(np.float32)
    return CloudSurface(Mesh(samples.points, normals=normals))
