"""The object: a trefoil knot with a bumpy tube, 0.3 m large, met exactly by rays (Newton's method on its formula)."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
EXTENT = 0.30  # [m]
STEP = 0.01  # two places on one ray that lie closer together are one [m]
PASSES = 4
GRID = (2400, 320)  # first guesses along and around the tube, closer together than pixels


class Knot:
    """The tube as a function of two angles, scaled and centred."""

    def __init__(self) -> None:
        self.scale, self.centre = 1.0, np.zeros(3)
        self.angles = np.stack([g.ravel() for g in np.meshgrid(*map(_turn, GRID), indexing="ij")])
        whole = self.points(*self.angles)
        low, high = whole.min(axis=0), whole.max(axis=0)
        self.centre, self.scale = (low + high) / 2, EXTENT / float(np.max(high - low))
        self.cloud = self.points(*self.angles)

    def points(self, u: Array, v: Array) -> Array:
        """(n, 3) [m] at angles along (n,) and around (n,) the tube."""
        tangent = np.stack([np.cos(u) + 4 * np.cos(2 * u), 4 * np.sin(2 * u) - np.sin(u), -3 * np.cos(3 * u)], -1)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        normal = np.cross([0.0, 0.0, 1.0], tangent)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        middle = np.stack([np.sin(u) + 2 * np.sin(2 * u), np.cos(u) - 2 * np.cos(2 * u), -np.sin(3 * u)], -1)
        radius = 0.62 + 0.07 * np.sin(30 * u) * np.sin(6 * v) + 0.03 * np.sin(71 * u + 3 * v)
        around = np.cos(v)[:, None] * normal + np.sin(v)[:, None] * np.cross(tangent, normal)
        return (middle + radius[:, None] * around - self.centre) * self.scale

    def mesh(self, along: int = 1000, around: int = 100) -> tuple[Array, NDArray[np.int32]]:
        """A closed mesh: vertices (n, 3) [m] and faces (m, 3)."""
        u, v = (g.ravel() for g in np.meshgrid(_turn(along), _turn(around), indexing="ij"))
        i, j = (g.ravel() for g in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
        a, b = i * around + j, (i + 1) % along * around + j
        c, d = (i + 1) % along * around + (j + 1) % around, i * around + (j + 1) % around
        faces = np.concatenate([np.stack([a, c, b], 1), np.stack([a, d, c], 1)])
        return self.points(u, v), faces.astype(np.int32)

    def depth(self, T_world_camera: Array, rays: Array, focal: float, centre: tuple[float, float]) -> Array:
        """Planar depth (h, w) [m] along rays (h, w, 3) with z = 1; 0 where the tube is not met."""
        h, w = rays.shape[:2]
        R, eye = T_world_camera[:3, :3], T_world_camera[:3, 3]
        local = (self.cloud - eye) @ R
        pixel = np.rint(local[:, :2] / local[:, 2:] * focal + centre).astype(int)
        flat = pixel[:, 1] * w + pixel[:, 0]
        order = np.argsort(local[:, 2])
        out = np.zeros(h * w)
        for _ in range(PASSES):  # a ray that passes beside what its pixel shows may meet what lies behind
            seen, first = np.unique(flat[order], return_index=True)  # the nearest point in each pixel
            start = local[order[first], 2]
            guess = np.stack([*self.angles[:, order[first]], start])
            t, met = self._refined(guess, eye, rays.reshape(-1, 3)[seen] @ R.T)
            out[seen[met]] = t[met]
            limit = np.full(h * w, np.inf)
            limit[seen[~met]] = start[~met] + STEP
            order = order[local[order, 2] > limit[flat[order]]]
            if not len(order):
                break
        return _without_strays(out.reshape(h, w))

    def _refined(self, guess: Array, eye: Array, d: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Depths (n,) at which rays meet the tube near guesses (3, n) of both angles and the depth; do they meet it."""
        u, v, t = guess.copy()
        for _ in range(6):  # Newton on points(u, v) - eye - t d = 0
            p, e = self.points(u, v), 1e-5
            J = np.stack([(self.points(u + e, v) - p) / e, (self.points(u, v + e) - p) / e, -d], axis=2)
            J += np.eye(3) * 1e-12  # along the rim it has no inverse
            step = np.linalg.solve(J, (p - eye - t[:, None] * d)[..., None])[..., 0]
            step *= np.minimum(1, 0.05 / np.maximum(np.abs(step[:, :2]).max(axis=1), 1e-12))[:, None]
            u, v, t = u - step[:, 0], v - step[:, 1], t - step[:, 2]
        miss = np.linalg.norm(self.points(u, v) - eye - t[:, None] * d, axis=1)
        facing = np.einsum("ij,ij->i", np.cross(J[:, :, 1], J[:, :, 0]), d) < 0
        return t, (miss < 1e-6) & (np.abs(t - guess[2]) < STEP) & facing


def _without_strays(depth: Array) -> Array:
    """Drops single pixels behind all their neighbours, where the near side was not found."""
    h, w = depth.shape
    padded = np.pad(depth, 1)
    around = [padded[1 + i : 1 + i + h, 1 + j : 1 + j + w] for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    similar = sum(((depth - n < STEP) & (n > 0)).astype(int) for n in around)
    return np.where(similar >= 2, depth, 0.0)


def _turn(n: int) -> Array:
    return np.arange(n) * 2 * np.pi / n
