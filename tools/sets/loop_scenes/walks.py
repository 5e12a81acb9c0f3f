"""How a person carries a camera: round a room or round a table, with jitter, and with a jerk where there is one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from tools.sets.loop_scenes.place.prints import Array, Rng

RATE = 30.0  # [frames/s]
TURN = 2 * np.pi
OVERLAP = np.deg2rad(45)  # more than a whole turn, so that the end sees what the start saw
STEP = np.deg2rad(1.0)  # of yaw per frame: 30 deg/s
EXPOSURE = 0.010  # [s] (guess: lamps at home)


@dataclass(frozen=True)
class Walk:
    """Attributes:
    times: (n,) [s].
    poses: (n, 4, 4) camera to world.
    blank: (n,) frames without depth.
    swept: (n, 2) how far the camera turns during an exposure [rad], about its y and its x axis.
    gaps: indices of the first frames after missing ones.
    """

    times: Array
    poses: Array
    blank: NDArray[np.bool_]
    swept: Array
    gaps: tuple[int, ...]

    def part(self, first: int, last: int) -> "Walk":
        """Frames first to last - 1 alone."""
        kept = slice(first, last)
        gaps = tuple(g - first for g in self.gaps if first <= g < last)
        return Walk(self.times[kept], self.poses[kept], self.blank[kept], self.swept[kept], gaps)


def wander(rng: Rng, count: int, spread: float, seconds: float) -> Array:
    """(count,) smooth random numbers of mean zero and standard deviation `spread`, changing within `seconds`."""
    pad = int(6 * seconds * RATE) + 1
    rough = gaussian_filter1d(rng.standard_normal(count + 2 * pad), seconds * RATE / np.sqrt(2), mode="wrap")
    return np.asarray(spread * rough[pad:-pad] / rough.std())


def paces(rng: Rng, total: float, step: float) -> Array:
    """(n,) from 0 to `total`, in uneven steps: people slow down and speed up."""
    count = int(np.ceil(total / step)) + 1
    speed = np.clip(1 + wander(rng, count, 0.3, 1.0), 0.3, 1.8)
    way = np.concatenate([[0.0], np.cumsum(speed)[:-1]])
    return np.asarray(way * total / way[-1])


def jerk(yaw: Array, at: int, back: float, quick: int) -> Array:
    """From frame `at` the camera is swung back by `back` [rad] within `quick` frames, then goes on as before."""
    s = np.linspace(0, 1, quick + 1)[1:]
    swing = yaw[at] - back * (3 * s**2 - 2 * s**3)
    again = np.flatnonzero(yaw > swing[-1])[0]
    return np.concatenate([yaw[: at + 1], swing, yaw[again:]])


def looking(yaw: Array, pitch: Array, roll: Array, centre: Array) -> Array:
    """(n, 4, 4) of cameras (x right, y down, z forward) at (n, 3) [m] that look along yaw, `pitch` up [rad]."""
    level = Rotation.from_matrix([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])  # looks along +x, its x to the right, -y
    turn = Rotation.from_euler("ZYX", np.stack([yaw, -pitch, roll], axis=1))
    out = np.tile(np.eye(4), (len(yaw), 1, 1))
    out[:, :3, :3] = (turn * level).as_matrix()
    out[:, :3, 3] = centre
    return out


def by_hand(rng: Rng, poses: Array) -> Array:
    """The same with a hand's jitter: 1 to 2 cm and 1 to 2 deg along and about each axis, within 0.2 to 0.6 s."""
    count = len(poses)
    shift = np.stack([wander(rng, count, rng.uniform(0.006, 0.012), rng.uniform(0.2, 0.6)) for _ in range(3)], axis=1)
    twist = [wander(rng, count, np.deg2rad(rng.uniform(0.6, 1.2)), rng.uniform(0.2, 0.6)) for _ in range(3)]
    out = poses.copy()
    out[:, :3, 3] += shift
    out[:, :3, :3] = poses[:, :3, :3] @ Rotation.from_rotvec(np.stack(twist, axis=1)).as_matrix()
    return out


def stamped(rng: Rng, poses: Array, blank: NDArray[np.bool_], dropped: NDArray[np.bool_]) -> Walk:
    """With time stamps that a computer gives; `dropped` frames never arrive."""
    count = len(poses)
    turn = Rotation.from_matrix(poses[:, :3, :3])
    each = (turn[:-1].inv() * turn[1:]).as_rotvec()
    swept = np.concatenate([each[:1], each])[:, :2][:, ::-1] * EXPOSURE * RATE
    times = 1000.0 + np.arange(count) / RATE + rng.uniform(-0.001, 0.001, count)
    kept = np.flatnonzero(~dropped)
    gaps = tuple(int(i) + 1 for i in np.flatnonzero(np.diff(kept) > 1))
    return Walk(times[kept], poses[kept], blank[kept], swept[kept], gaps)


def round_a_room(
    rng: Rng, size: tuple[float, float], start: float, across: bool, jerked: bool = False, carried: bool = False
) -> Walk:
    """A whole turn and a bit, looking outwards, or across the room; yaw begins at `start` [rad].

    `jerked`: within a third of a second the camera looks elsewhere. `carried`: it is covered, carried back by a part of
    the way within 1.7 s, and held higher or lower.
    """
    way = rng.choice([-1, 1])
    yaw = paces(rng, TURN + OVERLAP, 1.2 * STEP if carried else STEP)
    blank = dropped = np.zeros(len(yaw), bool)
    if jerked:
        at, quick = int(len(yaw) * rng.uniform(0.45, 0.6)), int(rng.integers(10, 13))
        yaw = jerk(yaw, at, np.deg2rad(rng.uniform(60, 80)), quick)
        blank, dropped = np.zeros(len(yaw), bool), np.zeros(len(yaw), bool)
        blank[at + 2 : at + quick - 1] = True
        dropped[at + 4 : at + 7] = True
        alone = int(len(yaw) * 0.25)  # one more pair without depth: nothing is lost by them
        blank[alone : alone + 2] = True
    if carried:
        at, quick = int(len(yaw) * rng.uniform(0.5, 0.65)), 50
        yaw = jerk(yaw, at, np.deg2rad(rng.uniform(70, 95)), quick)
        blank, dropped = np.zeros(len(yaw), bool), np.zeros(len(yaw), bool)
        blank[at + 1 : at + quick + 1] = True
        dropped[at + 4 : at + quick - 3] = True
    count = len(yaw)
    around = gaussian_filter1d(yaw, 8.0 if carried else 20.0, mode="nearest")  # feet are slower than hands
    around = start + way * around + (np.pi if across else 0) + np.deg2rad(wander(rng, count, 8, 2.0))
    wall = 1.35 if across else 1.75  # [m] from the feet to the nearest wall (guess: room for furniture, and a picture)
    radius = (0.5 * np.array(size) - wall) * rng.uniform(0.9, 1.1)
    steps = np.arange(count) / RATE
    height = 1.4 + 0.015 * np.sin(TURN * 1.8 * steps) + wander(rng, count, 0.05, 1.5)
    if carried:
        height = height + rng.choice([-1, 1]) * rng.uniform(0.12, 0.2) * (np.arange(count) > at + quick // 2)
    centre = np.stack([radius[0] * np.cos(around), radius[1] * np.sin(around), height], axis=1)
    facing = start + way * yaw + np.deg2rad(wander(rng, count, 4, 1.5))
    pitch = np.deg2rad((-14 if across else -22) + wander(rng, count, 5, 1.5))  # down: wall and floor
    poses = by_hand(rng, looking(facing, pitch, np.deg2rad(wander(rng, count, 2, 1.0)), centre))
    return stamped(rng, poses, blank, dropped)


def round_a_table(rng: Rng, aim: Array) -> Walk:
    """A whole turn and a bit round what stands at `aim` (3,) [m], looking at it from about 0.8 m."""
    way = rng.choice([-1, 1])
    around = rng.uniform(0, TURN) + way * paces(rng, TURN + OVERLAP, STEP)
    count = len(around)
    far = rng.uniform(0.75, 0.85) + wander(rng, count, 0.04, 1.5)
    up = np.deg2rad(rng.uniform(28, 36) + wander(rng, count, 4, 1.5))
    out = np.stack([np.cos(around) * np.cos(up), np.sin(around) * np.cos(up), np.sin(up)], axis=1)
    off = [np.deg2rad(wander(rng, count, 2, 1.0)) for _ in range(3)]
    poses = looking(around + np.pi + off[0], -up + off[1], off[2], aim + far[:, None] * out)
    nothing = np.zeros(count, bool)
    return stamped(rng, by_hand(rng, poses), nothing, nothing)
