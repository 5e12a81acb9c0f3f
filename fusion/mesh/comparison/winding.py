"""Faces of a mesh turned so that they look outwards, where it tells which way that is."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fusion.mesh.comparison.edges import MeshEdges
from fusion.mesh.comparison.nested import containers
from fusion.mesh.comparison.surface_samples import face_areas
from fusion.mesh.mesh import Mesh

Rows = NDArray[np.bool_]
_WORTH = 5e-4  # of the area in doubt that is told: less is 0.0 %
# of an open piece: so little that looks the other way than the rest, or is there twice, is no doubt (guess)
_FEW = 0.01


@dataclass(frozen=True, eq=False)
class Wound:
    """A mesh whose faces look outwards as far as that can be told.

    Attributes:
        mesh: so; the very arrays that were given where nothing was to be done.
        edges: of it.
        turned: (m,) which of the given faces were turned round.
        twins: (m,) which of them were left out: they lie on others that look the other way.
        doubtful: 0-1, share of the area where nothing tells which side is the outer one.
        solid: all of it is closed bodies: its faces do look outwards.
    """

    mesh: Mesh
    edges: MeshEdges
    turned: Rows
    twins: Rows
    doubtful: float = 0.0
    solid: bool = False

    @property
    def whole(self) -> bool:
        """As it was given, or as a whole the other way round."""
        return not self.twins.any() and bool(self.turned.all() or not self.turned.any())

    def applied(self, mesh: Mesh) -> Mesh:
        """The same done to the mesh that it was made of before vertices were joined; as a whole nothing is turned."""
        if self.whole:
            return mesh
        area = face_areas(mesh) > 0
        faces = mesh.faces[area]
        faces[self.turned] = faces[self.turned, ::-1]
        return replace(mesh, faces=faces[~self.twins])

    def notes(self) -> list[str]:
        """Sentences on what was done to a reference."""
        said = []
        if self.twins.any():
            said.append(f"{self.twins.sum()} faces of the reference lie on others that look the other way: left out.")
        if self.turned.any() and not self.turned[~self.twins].all():
            said.append(f"{self.turned.sum()} of {len(self.turned)} faces of the reference pointed inwards: turned.")
        if self.doubtful > _WORTH:
            said.append(
                "Faces of the reference look against their neighbours where nothing tells which of them look outwards "
                "(it is open, or more than two faces share an edge): outside and inside of it, and so the bias, are "
                "uncertain; give a reference whose faces all look outwards."
            )
        return said


def wound(mesh: Mesh) -> Wound:
    """Faces that hang together are turned alike, and those of each closed body outwards.

    A body within another one is its cavity, or a thing in it: it stays as it is, unless it is in itself of two minds.
    Of an open piece of two minds the larger part of the area is right. Open pieces that look one way stay.

    Args:
        mesh: its vertices `joined`, its faces with area.
    """
    edges = MeshEdges.of(mesh)
    none = np.zeros(len(mesh.faces), bool)
    twins = _twins(mesh.faces, edges) if (edges.count > 2).any() else none
    if twins.any():
        rest = _wound(replace(mesh, faces=mesh.faces[~twins]))
        turned = none.copy()
        turned[~twins] = rest.turned
        open_sheet = bool((rest.edges.count == 1).any()) and twins.mean() > _FEW  # either side of it may be meant
        return replace(rest, turned=turned, twins=twins, doubtful=1.0 if open_sheet else rest.doubtful)
    return _wound(mesh, edges)


def _wound(mesh: Mesh, edges: MeshEdges | None = None) -> Wound:
    edges = edges or MeshEdges.of(mesh)
    areas, none = face_areas(mesh), np.zeros(len(mesh.faces), bool)
    pairs, alike = edges.pairs(), edges.way.ravel()
    against = alike[pairs[:, 0]] == alike[pairs[:, 1]]
    piece, turned = _pieces(pairs // 3, against, areas)
    now = edges.turned(turned) if turned.any() else edges
    mixed = np.zeros(piece.max() + 1, bool)
    mixed[piece[pairs[against, 0] // 3]] = True
    closed = _closed(now, piece)
    a, b, c = (mesh.vertices[mesh.faces[:, i]] - mesh.vertices.mean(axis=0) for i in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) * np.where(turned, -1, 1)
    whole = bool(closed.all())
    if whole and not mixed.any() and volumes.sum() < 0:
        turned, volumes = ~turned, -volumes
    inwards = np.bincount(piece, volumes) < 0
    asked = closed & (mixed | (inwards if whole else False))  # where it is open, what is around a body is not known
    if asked.any():
        turned = turned ^ ((mixed | whole) & _inwards(mesh, piece, np.flatnonzero(closed), mixed, inwards))[piece]
    if not turned.any():
        return Wound(mesh, edges, none, none, _doubtful(edges, piece, mixed & ~closed, none, areas), whole)
    faces = mesh.faces[:, ::-1] if turned.all() else np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces)
    now = edges.turned(turned)
    doubtful = _doubtful(now, piece, mixed & ~closed, turned, areas)
    return Wound(replace(mesh, faces=faces), now, turned, none, doubtful, whole)


def _twins(faces: NDArray[np.integer], edges: MeshEdges) -> Rows:
    """Faces (m,) that lie on an earlier one the other way round; none where walls of closed bodies touch so."""
    _, index = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True)
    index = index.reshape(-1)
    even = (np.roll(faces, -1, axis=1) > faces).sum(axis=1) == 2  # the corners follow each other as when sorted
    first = np.empty(index.max() + 1, np.intp)
    first[index[::-1]] = np.arange(len(faces))[::-1]
    twins = np.asarray(even != even[first[index]])
    balance = edges.balance()
    without = balance - np.bincount(edges.index[twins].ravel(), edges.way[twins].ravel(), len(balance))
    both = 2 * twins.sum() == len(faces)  # a surface that was written from both sides
    return twins if both or np.count_nonzero(without) < np.count_nonzero(balance) else np.zeros(len(faces), bool)


def _pieces(pairs: NDArray[np.intp], against: Rows, areas: NDArray[np.float64]) -> tuple[NDArray[np.intp], Rows]:
    """Which piece each of m faces is of, and which to turn so that each piece looks one way, as most of its area does.

    Each face stands there twice, as it is and turned; what two faces agree on hangs together. The two halves of a
    piece are its two sides; where there is only one half (a Moebius strip) nothing is turned.
    """
    count = len(areas)
    one, other = pairs.T
    if not against.any():
        graph = coo_array((np.ones(len(one), np.int8), (one, other)), (count, count))
        return connected_components(graph, False)[1].astype(np.intp), np.zeros(count, bool)
    to = other + count * against
    rows, columns = np.r_[one, one + count], np.r_[to, (to + count) % (2 * count)]
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), (2 * count, 2 * count))
    side = connected_components(graph, False)[1]
    here, there = side[:count], side[count:]
    piece = np.unique(np.minimum(here, there), return_inverse=True)[1].reshape(-1)
    turned = here > there
    for_it = np.bincount(piece, np.where(turned, areas, -areas))
    return piece, turned ^ ((for_it > 0)[piece] & (here != there))


def _closed(edges: MeshEdges, piece: NDArray[np.intp]) -> Rows:
    """Which pieces are: each of their edges is run along forth as often as back."""
    edge, of = edges.index.ravel(), np.repeat(piece, 3)
    many = edges.count[edge] > 2  # where pieces meet each is asked for itself
    closed = np.ones(piece.max() + 1, bool)
    closed[of[~many & (edges.balance()[edge] != 0)]] = False
    if many.any():
        both, index = np.unique(np.column_stack([edge[many], of[many]]), axis=0, return_inverse=True)
        left = np.bincount(index.reshape(-1), edges.way.ravel()[many])
        closed[both[left != 0, 1]] = False
    return closed


def _inwards(mesh: Mesh, piece: NDArray[np.intp], closed: NDArray[np.intp], mixed: Rows, inwards: Rows) -> Rows:
    """Which pieces are to be turned, of the closed ones by their numbers."""
    around = containers(mesh, piece, closed)
    turned = np.zeros_like(mixed)
    outermost = [k for k in closed if not around[k]]
    turned[outermost] = inwards[outermost]
    for k in closed:
        if not around[k]:
            continue
        if mixed[k]:  # the cavity of a body, a body in a cavity
            turned[k] = inwards[k] == (len(around[k]) % 2 == 0)
        else:  # with the body that it is in
            turned[k] = any(turned[j] and not mixed[j] for j in around[k] if not around[j])
    return turned


def _doubtful(
    edges: MeshEdges, piece: NDArray[np.intp], open_mixed: Rows, turned: Rows, areas: NDArray[np.float64]
) -> float:
    """Share of the area where faces still look against each other, or where the larger part of an open piece chose."""
    left = np.abs(edges.balance()) > edges.count % 2
    few = np.bincount(piece, areas * turned) <= _FEW * np.bincount(piece, areas)
    rows = (left & (edges.count > 1))[edges.index].any(axis=1) | (open_mixed & ~few)[piece]
    return float(areas[rows].sum() / areas.sum())
