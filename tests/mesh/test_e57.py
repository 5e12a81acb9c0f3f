"""E57: written node by node with the library that others write it with."""

import sys

import numpy as np
import pye57
import pytest
from pye57 import libe57

from fusion import read_mesh, write_mesh
from fusion.errors import MeshError

POINTS = np.array([[0.1, 0.2, 0.3], [-0.4, 0.5, 0.6], [0.7, -0.8, -0.9], [1.0, 1.1, -1.2]])
COLORS = np.array([[0, 128, 255], [255, 0, 1], [2, 3, 4], [5, 6, 7]], np.uint8)


def write_e57(path, *scans):
    """Scans of columns by name; "pose": rotation and translation by name; "colorLimits": the largest colour."""
    with pye57.E57(str(path), "w") as file:
        image = file.image_file
        for scan in scans:
            node, proto = libe57.StructureNode(image), libe57.StructureNode(image)
            columns = {name: np.ascontiguousarray(c, float) for name, c in scan.items() if np.ndim(c) == 1}
            buffers = libe57.VectorSourceDestBuffer()
            for name, column in columns.items():
                proto.set(name, libe57.FloatNode(image, 0.0))
                buffers.append(libe57.SourceDestBuffer(image, name, column, len(column), True, True))
            for part, numbers in scan.get("pose", {}).items():
                if not node.isDefined("pose"):
                    node.set("pose", libe57.StructureNode(image))
                node["pose"].set(part, libe57.StructureNode(image))
                for name, value in numbers.items():
                    node["pose"][part].set(name, libe57.FloatNode(image, value))
            if "colorLimits" in scan:
                node.set("colorLimits", libe57.StructureNode(image))
                for name in ("Red", "Green", "Blue"):
                    node["colorLimits"].set(f"color{name}Maximum", libe57.FloatNode(image, scan["colorLimits"]))
            file.data3d.append(node)
            points = libe57.CompressedVectorNode(image, proto, libe57.VectorNode(image, True))
            node.set("points", points)
            writer = points.writer(buffers)
            writer.write(len(next(iter(columns.values()))))
            writer.close()


def cartesian(points=POINTS):
    return dict(zip(("cartesianX", "cartesianY", "cartesianZ"), points.T, strict=True))


def colors(largest):
    values = COLORS.astype(float) / 255 * largest
    return dict(zip(("colorRed", "colorGreen", "colorBlue"), values.T, strict=True)) | {"colorLimits": largest}


@pytest.mark.parametrize("largest", [255.0, 1.0, 65535.0])
def test_points_and_colours(tmp_path, largest):
    write_e57(tmp_path / "a.e57", cartesian() | colors(largest))
    cloud = read_mesh(tmp_path / "a.e57")
    np.testing.assert_array_equal(cloud.vertices, POINTS)
    np.testing.assert_array_equal(cloud.colors, COLORS)


def test_scans_are_brought_to_their_places(tmp_path):
    # a quarter turn about z, its parts not in the usual order: x becomes y
    quarter = {"z": np.sqrt(0.5), "x": 0.0, "y": 0.0, "w": np.sqrt(0.5)}
    pose = {"translation": {"z": 3.0, "x": 1.0, "y": 2.0}, "rotation": quarter}
    write_e57(tmp_path / "a.e57", cartesian() | {"pose": pose}, cartesian() | colors(255.0))
    cloud = read_mesh(tmp_path / "a.e57")
    turned = np.column_stack([-POINTS[:, 1], POINTS[:, 0], POINTS[:, 2]]) + np.array([1.0, 2, 3])
    np.testing.assert_allclose(cloud.vertices, [*turned, *POINTS], atol=1e-15)
    assert cloud.colors is None  # one of them has none


def test_angles_and_distance(tmp_path):
    x, y, z = POINTS.T
    distance = np.linalg.norm(POINTS, axis=1)
    angles = {"sphericalAzimuth": np.arctan2(y, x), "sphericalElevation": np.arcsin(z / distance)}
    invalid = {"sphericalInvalidState": np.array([0, 1, 0, 2])}
    write_e57(tmp_path / "a.e57", {"sphericalRange": distance} | angles | invalid)
    np.testing.assert_allclose(read_mesh(tmp_path / "a.e57").vertices, POINTS[[0, 2]], atol=1e-15)


def test_broken_files_are_refused_and_stay(tmp_path):
    path = tmp_path / "a.e57"
    write_e57(path, cartesian())
    good = path.read_bytes()
    broken = {
        good[:-1024]: "ErrorBadFileLength",
        good[:60] + b"x" + good[61:]: "ErrorBadChecksum",
        b"no scan at all" * 100: "cannot be read",
    }
    for data, words in broken.items():
        path.write_bytes(data)
        with pytest.raises(MeshError, match=words):
            read_mesh(path)
        assert path.read_bytes() == data
    write_e57(tmp_path / "none.e57")
    with pytest.raises(MeshError, match="no scan with points"):
        read_mesh(tmp_path / "none.e57")
    write_e57(tmp_path / "other.e57", {"intensity": np.ones(3)})
    with pytest.raises(MeshError, match="no coordinates among intensity"):
        read_mesh(tmp_path / "other.e57")
    write_e57(tmp_path / "turn.e57", cartesian() | {"pose": {"rotation": {"w": 0.0}}})
    with pytest.raises(MeshError, match="is no pose"):
        read_mesh(tmp_path / "turn.e57")


def test_without_the_library_its_extra_is_named(tmp_path, monkeypatch):
    write_e57(tmp_path / "a.e57", cartesian())
    monkeypatch.setitem(sys.modules, "pye57", None)
    with pytest.raises(MeshError, match=r'a\.e57.*pip install "fusion-scan\[e57\]"'):
        read_mesh(tmp_path / "a.e57")


def test_it_is_not_written(tmp_path):
    write_e57(tmp_path / "a.e57", cartesian())
    with pytest.raises(MeshError, match=r"only read.*\.ply"):
        write_mesh(tmp_path / "b.e57", read_mesh(tmp_path / "a.e57"))
    assert not (tmp_path / "b.e57").exists()
