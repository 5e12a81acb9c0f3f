"""Where frames stand, as `/tf` and `/tf_static` say: a tree whose links may change with time."""

import struct
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.errors import RecordingError
from fusion.geometry.pose import Array, inverse, pose
from fusion.geometry.trajectory import Trajectory
from fusion.recording.formats.bags.containers.store import Store, Topic
from fusion.recording.formats.bags.messages.values import CDR_HEAD

TYPES = ("tf2_msgs/TFMessage", "tf/tfMessage")
MOST = 5_000_000  # transforms: each takes some 100 bytes
LONGEST_GAP_S = 0.5  # between two places of a link: what a slow localisation sends; beyond that nobody knows
ROUNDING_S = 1e-6  # seconds since 1970 as a number hold a quarter of it
FARTHEST_M = 1e6


@dataclass(frozen=True)
class Link:
    """A frame in its parent: stamps (n,) [s] rising, places (n, 7) as TUM's tx ty tz qx qy qz qw."""

    parent: str
    stamps: NDArray[np.float64]
    places: NDArray[np.float64]

    @property
    def moves(self) -> bool:
        """True where it stands at more than one place."""
        return len(self.places) > 1 and bool((np.abs(self.places - self.places[0]) > 1e-9).any())

    def at(self, stamps: NDArray[np.float64]) -> Array:
        """(n, 4, 4) at some stamps [s], between the places known; NaN where there is none near in time."""
        from scipy.spatial.transform import Rotation, Slerp

        if not self.moves:
            return np.broadcast_to(_poses(self.places[:1]), (len(stamps), 4, 4)).copy()
        known = np.clip(stamps, self.stamps[0], self.stamps[-1])
        after = np.clip(np.searchsorted(self.stamps, known), 1, len(self.stamps) - 1)
        before, behind = self.stamps[after - 1], self.stamps[after]
        nearest = np.where(known - before < behind - known, before, behind)
        exact = np.abs(known - nearest) < ROUNDING_S
        known = np.where(exact, nearest, known)
        out = np.tile(np.eye(4), (len(stamps), 1, 1))
        out[:, :3, :3] = Slerp(self.stamps, Rotation.from_quat(self.places[:, 3:]))(known).as_matrix()
        for axis in range(3):
            out[:, axis, 3] = np.interp(known, self.stamps, self.places[:, axis])
        wide = behind - before > LONGEST_GAP_S
        out[(wide & ~exact) | (np.abs(stamps - known) > LONGEST_GAP_S)] = np.nan
        return out


Tree = dict[str, Link]


def read_tree(store: Store) -> Tree:
    """All frames of a bag by name. Raises RecordingError."""
    rows: dict[str, dict[str, list[tuple[float, ...]]]] = defaultdict(lambda: defaultdict(list))
    count = 0
    for topic in store.topics.values():
        if topic.type not in TYPES:
            continue
        for index in range(len(topic)):
            for parent, child, row in _transforms(topic, index):
                rows[child][parent].append(row)
                count += 1
                if count > MOST:
                    raise RecordingError("the bag has too many transforms", topic.name, count, f"at most {MOST}")
    return {child: _link(parents) for child, parents in rows.items()}


def poses_at(tree: Tree, frame: str, stamps: NDArray[np.float64]) -> Trajectory | None:
    """Poses of a frame in the topmost one above it; None where nothing between them moves."""
    above = _above(tree, frame)
    if not any(tree[name].moves for name in above):
        return None
    poses = np.tile(np.eye(4), (len(stamps), 1, 1))
    for name in above:
        poses = tree[name].at(stamps) @ poses
    return Trajectory(stamps, poses) if np.isfinite(poses).all(axis=(1, 2)).any() else None


def stated_poses(tree: Tree, frame: str) -> Trajectory | None:
    """Poses of a frame in the one above it as they were written, at stamps of their own; None where there are none.

    Nothing is put between them, and a frame that stands still has poses too: of files that say nothing else by it.
    """
    link = tree.get(frame)
    return None if link is None else Trajectory(link.stamps, _poses(link.places))


def between(tree: Tree, one: str, other: str, stamp: float) -> Array | None:
    """(4, 4) that maps points of frame `one` to frame `other`, at a stamp [s]; None where nothing joins them."""
    if one == other:
        return np.eye(4)
    paths = {name: [*_above(tree, name)] for name in (one, other)}
    tops = {name: tree[path[-1]].parent if path else name for name, path in paths.items()}
    if tops[one] != tops[other]:
        return None
    T = {}
    for name, path in paths.items():
        # links that both share say nothing of the two, and may be unknown at this moment
        own = [link for link in path if link not in paths[other if name == one else one]]
        T[name] = np.eye(4)
        for link in own:
            T[name] = tree[link].at(np.array([stamp]))[0] @ T[name]
    found = inverse(T[other]) @ T[one]
    return found if np.isfinite(found).all() else None


def _above(tree: Tree, frame: str) -> list[str]:
    """The frame and those above it whose links lead to the topmost one, from the lowest."""
    path: list[str] = []
    while frame in tree and frame not in path:
        path.append(frame)
        frame = tree[frame].parent
    return path


def _link(parents: dict[str, list[tuple[float, ...]]]) -> Link:
    # a child of two is not a tree: the one that was said most often counts
    parent = max(parents, key=lambda name: len(parents[name]))
    rows = np.array(parents[parent], float)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    rows = rows[np.concatenate([rows[1:, 0] != rows[:-1, 0], [True]])]  # of equal stamps the last
    return Link(parent, rows[:, 0], rows[:, 1:])


def _poses(places: NDArray[np.float64]) -> Array:
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_quat(places[:, 3:]).as_matrix()
    return np.stack([pose(R, t) for R, t in zip(turns, places[:, :3], strict=True)])


def _transforms(topic: Topic, index: int) -> list[tuple[str, str, tuple[float, ...]]]:
    """Parent, child, and stamp [s] with place of each transform in a message; taken apart here, as there are many."""
    data, found = topic.read(index, -1), []
    order = ">" if topic.ros2 and len(data) > 1 and data[1] == 0 else "<"
    at = CDR_HEAD if topic.ros2 else 0

    def padded(place: int, size: int) -> int:
        return place + -(place - CDR_HEAD) % size if topic.ros2 else place

    def text(place: int) -> tuple[str, int]:
        place = padded(place, 4)
        (length,) = struct.unpack_from(f"{order}I", data, place)
        end = place + 4 + length
        if end > len(data):
            raise struct.error
        name = data[place + 4 : end]
        return name.rstrip(b"\0").decode("utf-8", "replace").lstrip("/"), end

    try:
        (count,) = struct.unpack_from(f"{order}I", data, at)
        at += 4
        for _ in range(min(count, len(data) // 56)):  # each holds seven doubles at least
            at = padded(at, 4) if topic.ros2 else at + 4  # past ROS 1's counter
            seconds, nanoseconds = struct.unpack_from(f"{order}II", data, at)
            parent, at = text(at + 8)
            child, at = text(at)
            at = padded(at, 8)
            place = struct.unpack_from(f"{order}7d", data, at)
            at += 56
            length = sum(q * q for q in place[3:])
            if 0.5 < length < 2 and all(abs(value) < FARTHEST_M for value in place[:3]):
                found.append((parent, child, ((seconds * 10**9 + nanoseconds) / 1e9, *place)))
    except struct.error as problem:
        raise RecordingError("a message cannot be read", topic.name, f"{len(data)} bytes", topic.type) from problem
    return found
