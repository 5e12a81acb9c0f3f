"""No kernel gets the same memory twice: on a card each array is a copy of its own, and one of the two would be lost."""

import numpy as np

from fusion.compute.launch import Kernel, overlap
from fusion.compute.structures import apart
from fusion.geometry.camera import Camera
from fusion.geometry.depth import point_map
from fusion.tracking.icp import align
from fusion.volume.settings import VolumeSettings
from fusion.volume.volume import Volume

CAMERA = Camera(80, 60, 70.0, 70.0, 39.5, 29.5, (-0.1, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


def test_arrays_that_share_memory_are_seen():
    a = np.zeros((4, 6), np.float32)
    assert overlap((a, 1.0, a)) and overlap((a, a[1:2])) and overlap((a[:3].reshape(-1), a[2:]))
    assert not overlap((a[:2], a[2:], 3, np.zeros(2))) and not overlap((a, a[:0]))


def test_a_scan_hands_no_memory_over_twice(monkeypatch):
    called, shared, plain = set(), set(), Kernel.__call__

    def watched(self, *args):
        called.add(self.__name__)
        if overlap(apart(args)):
            shared.add(self.__name__)
        return plain(self, *args)

    monkeypatch.setattr(Kernel, "__call__", watched)
    v, u = np.indices(CAMERA.shape)
    depth = (1.0 + 0.05 * np.sin(u / 9) + 0.05 * np.cos(v / 7)).astype(np.float32)
    depth[:, :9] = np.nan
    for color in (None, np.full((*CAMERA.shape, 3), 99, np.uint8)):
        volume = Volume(VolumeSettings(0.01, 0.04, color=color is not None))
        for _ in range(2):
            volume.integrate(depth, CAMERA, np.eye(4), color=color)
        seen = volume.raycast(CAMERA, np.eye(4))
        mesh = volume.surface(min_weight=0.5)
        frame = point_map(depth, CAMERA)
        model = point_map(seen.depth, CAMERA)
        assert align(frame, model, np.eye(4)).status == "ok" and len(mesh.vertices)
    assert len(called) > 8 and not shared
