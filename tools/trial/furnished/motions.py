"""How cameras move: tripods, an arm, stops on a rail, sweeps by hand, a rail in motion; how wrong their poses are."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tools.trial.furnished.physics.bench import CameraRun
from tools.trial.furnished.physics.lens import StatedCamera
from tools.trial.furnished.physics.poses import Array, looking, moved
from tools.trial.furnished.physics.world import World
from tools.trial.furnished.rooms.parts import Furnished

Rng = np.random.Generator
FAR = 4.2  # [m] that the middle of a view is away at most
STANDING = ("tripod", "arm", "rail_stops")
# standard deviations of poses as stated [m, rad]
SIGMAS = {
    "tripod": (0.0008, 0.0006),
    "arm": (0.0002, 0.0003),
    "rail_stops": (0.0004, 0.0005),
    "sweep": (0.0015, 0.0015),
    "rail": (0.0005, 0.0005),
}


@dataclass(frozen=True)
class CameraWalk:
    """`sigma`: [m, rad] of a stated pose; `source`: how it is said to be known."""

    recordings: list[CameraRun]
    sigma: tuple[float, float]
    source: str


@dataclass(frozen=True)
class ViewDraws:
    """Draws poses from which enough of the scene is seen."""

    rng: Rng
    world: World
    scene: Furnished
    camera: StatedCamera

    def one(self) -> Array:
        for _ in range(80):
            eye, at = self._point(self.scene.eye), self._point(self.scene.aim)
            T = looking(eye, at, self.rng.normal(0, 0.06))
            if self.good(T):
                return T
        raise RuntimeError("no view")

    def good(self, T: Array, far: float = FAR) -> bool:
        """Whether most of a few rays meet something, neither too near nor too far."""
        c = self.camera
        u, v = np.linspace(0, c.width - 1, 12), np.linspace(0, c.height - 1, 9)
        flat = np.stack(np.meshgrid((u - c.cx) / c.fx, (v - c.cy) / c.fy), -1)
        z = self.world.cast(T, np.concatenate([flat, np.ones((*flat.shape[:2], 1))], -1)).z
        enough = np.isfinite(z).mean() > 0.6
        return bool(enough and np.nanmin(z) > 0.4 and np.nanmedian(z) < far and np.nanmax(z) < 6.5)

    def _point(self, limits: list[tuple[float, float]]) -> Array:
        return np.array([self.rng.uniform(*limit) for limit in limits])


def walk(views: ViewDraws, kind: str, budget: float) -> CameraWalk:
    """Recordings of one motion; `budget`: pixels of all frames together."""
    rng = views.rng
    start = float(rng.uniform(20, 200))
    rate = rng.choice([10, 15, 30])
    if kind in STANDING:
        recordings = _standing(views, kind, budget, start, rate)
    else:
        recordings = _moving(views, kind, budget, start, rate)
    return CameraWalk(recordings, SIGMAS[kind], "tracked" if kind == "sweep" else "surveyed")


def _standing(views: ViewDraws, kind: str, budget: float, start: float, rate: Any) -> list[CameraRun]:
    rng, pixels = views.rng, views.camera.width * views.camera.height
    n = int(rng.integers(5, 11)) if kind == "tripod" else int(rng.integers(6, 11))
    frames = int(np.clip(budget // (n * pixels), 4, rng.integers(6, 15)))
    n = int(min(n, budget // (4 * pixels)))
    first = views.one()
    poses = [pose for k in range(n) if (pose := _stop(views, kind, first, k, n)) is not None]
    if len(poses) < 3:
        raise RuntimeError("few views")
    out = []
    for k, T in enumerate(poses):
        times = start + np.arange(frames) / rate
        out.append(CameraRun(k, times, _at(T), True))
        start = times[-1] + float(rng.uniform(40, 260))
    return out


def _at(T: Array) -> Callable[[float], Array]:
    return lambda time: T


def _stop(views: ViewDraws, kind: str, first: Array, k: int, n: int) -> Array | None:
    """Where the camera stands for the k-th time of n."""
    rng = views.rng
    if kind == "tripod":
        return views.one()
    for _ in range(100):
        if kind == "arm":
            shift = np.array([(k % 3 - 1) * 0.22, (k // 3 - 1) * 0.18, rng.choice([-0.15, 0, 0.15])])
            T = first @ moved(np.r_[shift, rng.normal(0, 0.12, 3)])
        else:
            along = -0.6 + 1.9 * k / n + rng.normal(0, 0.02)
            T = first @ moved(np.r_[0, 0, along, rng.normal(0, 0.03, 3)])
        if views.good(T, FAR + 1):
            return T
    return None


def _moving(views: ViewDraws, kind: str, budget: float, start: float, rate: Any) -> list[CameraRun]:
    rng, pixels = views.rng, views.camera.width * views.camera.height
    n = int(rng.integers(4, 7))
    frames = int(np.clip(budget // (n * pixels), 8, 20))
    n = int(max(3, min(n, budget // (frames * pixels))))
    out = []
    for k in range(n):
        path = _path(views, kind, start, frames / rate)
        times = start + np.arange(frames) / rate
        out.append(CameraRun(k, times, path, False))
        start = times[-1] + float(rng.uniform(30, 200))
    return out


def _path(views: ViewDraws, kind: str, start: float, lasting: float) -> Callable[[float], Array]:
    for _ in range(200):
        first = views.one()
        path = _swept(views.rng, first, start) if kind == "sweep" else _railed(views.rng, first, start, lasting)
        if all(views.good(path(start + part * lasting)) for part in (0, 0.5, 1)):
            return path
    raise RuntimeError("no path")


def _swept(rng: Rng, first: Array, start: float) -> Callable[[float], Array]:
    """By hand: steady, with a sway."""
    speed, turn, sway = rng.normal(0, 0.25, 3), rng.normal(0, 0.2, 3), rng.normal(0, 0.05, 6)
    rate = rng.uniform(0.4, 1.2)

    def path(time: float) -> Array:
        since = time - start
        return first @ moved(np.r_[speed * since, turn * since] + sway * np.sin(2 * np.pi * rate * since) / 2)

    return path


def _railed(rng: Rng, first: Array, start: float, lasting: float) -> Callable[[float], Array]:
    """Along the optical axis."""
    speed = rng.choice([-1, 1]) * rng.uniform(0.3, 0.8)
    return lambda time: first @ moved(np.r_[0, 0, speed * (time - start - lasting / 2), 0, 0, 0])


def put_poses_wrong(recordings: list[CameraRun], sigma: tuple[float, float], factor: float, seed: int) -> None:
    """Gives each recording its true poses: one error for a camera that stands, half new in each frame of others."""
    for one in recordings:
        rng = np.random.default_rng([seed, 31, one.index])
        six = np.r_[[sigma[0]] * 3, [sigma[1]] * 3] * factor
        common = rng.standard_normal(6) * six
        if one.static:
            one.true = _off(one.stated, common)
        else:
            each = {round(float(t), 6): (common + rng.standard_normal(6) * six) * 0.7071 for t in one.times}
            one.true = _off_each(one.stated, each)


def _off(stated: Callable[[float], Array], error: Array) -> Callable[[float, float], Array]:
    return lambda time, frame: stated(time) @ moved(error)


def _off_each(stated: Callable[[float], Array], errors: dict[float, Array]) -> Callable[[float, float], Array]:
    return lambda time, frame: stated(time) @ moved(errors[round(float(frame), 6)])
