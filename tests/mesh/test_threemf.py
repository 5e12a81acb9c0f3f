"""3MF: read back by trimesh, which shares no code with the library that writes it; others' files by hand."""

import locale
import sys
import zipfile

import numpy as np
import pytest
import trimesh

from fusion import Mesh, read_mesh, write_mesh
from fusion.commands.main import main
from fusion.errors import MeshError
from fusion.mesh.formats import threemf

CORNERS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])  # [m], z up
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 8, 7]], np.uint8)
SCAN = Mesh(CORNERS, FACES, colors=COLORS)
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MORE = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
TYPES = (
    '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
RELATIONS = (
    '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="r" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
CUT = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)])
SIDES = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES)
SHAPE = f'<object id="1" type="model"><mesh><vertices>{CUT}</vertices><triangles>{SIDES}</triangles></mesh></object>'


def by_hand(path, resources=SHAPE, build='<item objectid="1"/>', unit="millimeter"):
    model = (
        f'<?xml version="1.0"?><model unit="{unit}" xmlns="{CORE}" xmlns:m="{MORE}">'
        f"<resources>{resources}</resources><build>{build}</build></model>"
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in {"[Content_Types].xml": TYPES, "_rels/.rels": RELATIONS, "3D/3dmodel.model": model}.items():
            file.writestr(name, text)
    return path


def test_a_foreign_reader_finds_millimetres_and_the_same_triangles(tmp_path):
    write_mesh(tmp_path / "a.3mf", SCAN)
    scene = trimesh.load_scene(tmp_path / "a.3mf", process=False)
    assert scene.units == "millimeter"
    (found,) = scene.dump()
    np.testing.assert_allclose(found.vertices, CORNERS * 1000, atol=1e-4)
    np.testing.assert_array_equal(found.faces, FACES)
    assert found.volume == pytest.approx(0.1 * 0.2 * 0.3 / 6 * 1e9, rel=1e-6)


def test_the_process_keeps_its_locale(tmp_path):
    """The library sets C, in which Python reads every later text as ASCII."""
    before = locale.setlocale(locale.LC_ALL)
    locale.setlocale(locale.LC_ALL, "C.UTF-8")
    try:
        write_mesh(tmp_path / "scan.3mf", SCAN)
        read_mesh(tmp_path / "scan.3mf")
        assert locale.setlocale(locale.LC_CTYPE) == "C.UTF-8"
    finally:
        locale.setlocale(locale.LC_ALL, before)


def test_it_comes_back_in_metres_with_its_colours(tmp_path):
    write_mesh(tmp_path / "a.3mf", SCAN)
    back = read_mesh(tmp_path / "a.3mf")
    np.testing.assert_allclose(back.vertices, CORNERS, atol=1e-7)  # single precision of 300 mm
    np.testing.assert_array_equal(back.faces, FACES)
    np.testing.assert_array_equal(back.colors, COLORS)
    write_mesh(tmp_path / "b.3mf", Mesh(CORNERS, FACES))
    assert read_mesh(tmp_path / "b.3mf").colors is None


def test_colours_stand_in_the_file_as_the_standard_has_them(tmp_path):
    write_mesh(tmp_path / "a.3mf", SCAN)
    with zipfile.ZipFile(tmp_path / "a.3mf") as file:
        text = file.read("3D/3dmodel.model").decode()
    assert all(f'color="#{r:02X}{g:02X}{b:02X}FF"' in text for r, g, b in COLORS.tolist())
    assert "<m:colorgroup" in text and 'pid="' in text and 'pindex="' in text


def test_convert_writes_millimetres_and_reads_them(tmp_path, capsys):
    write_mesh(tmp_path / "a.ply", SCAN)
    assert main(["convert", str(tmp_path / "a.ply"), str(tmp_path / "a.3mf")]) == 0
    assert "size: 0.1 x 0.2 x 0.3 m" in capsys.readouterr().out
    assert main(["convert", str(tmp_path / "a.3mf"), str(tmp_path / "a.stl")]) == 0
    assert "size: 100 x 200 x 300 mm" in capsys.readouterr().out
    assert main(["convert", str(tmp_path / "a.ply"), str(tmp_path / "b.3mf"), "--unit", "mm"]) == 1
    assert not (tmp_path / "b.3mf").exists()


@pytest.mark.parametrize("unit, metres", [("micron", 1e-6), ("centimeter", 0.01), ("inch", 0.0254), ("foot", 0.3048)])
def test_the_unit_is_that_of_the_file(tmp_path, unit, metres):
    mesh = read_mesh(by_hand(tmp_path / "a.3mf", unit=unit))
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), np.array([1, 2, 3]) * metres, rtol=1e-6)


def test_parts_stand_where_groups_and_the_plate_put_them(tmp_path):
    # twice: moved by 10 along x; and as a group, turned a quarter about z and moved, that is moved again
    group = '<object id="2" type="model"><components><component objectid="1" transform="0 1 0 -1 0 0 0 0 1 5 0 0"/>'
    build = '<item objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/><item objectid="2" transform="{}"/>'
    path = by_hand(tmp_path / "a.3mf", f"{SHAPE}{group}</components></object>", build.format("1 0 0 0 1 0 0 0 1 0 7 0"))
    mesh = read_mesh(path)
    first = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], float)
    turned = np.column_stack([-first[:, 1] + 5, first[:, 0] + 7, first[:, 2]])
    np.testing.assert_allclose(mesh.vertices * 1000, np.vstack([first + np.array([10, 0, 0]), turned]), atol=1e-5)
    mirror = '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'
    mirrored = read_mesh(by_hand(tmp_path / "m.3mf", build=mirror))
    assert mirrored.to_trimesh().volume == pytest.approx(1e-9)  # 1 x 2 x 3 / 6 mm^3: its faces still look outwards


def test_broken_files_are_one_line(tmp_path, monkeypatch):
    write_mesh(tmp_path / "good.3mf", SCAN)
    good = (tmp_path / "good.3mf").read_bytes()
    path = tmp_path / "a.3mf"
    for data in (b"no zip", good[:-30], good[:200] + b"xxxx" + good[204:]):
        path.write_bytes(data)
        with pytest.raises(MeshError, match=r"a\.3mf"):
            read_mesh(path)
    with pytest.raises(MeshError, match="nothing to print"):
        read_mesh(by_hand(path, build=""))
    monkeypatch.setattr(threemf, "MOST_PARTS", 5)
    with pytest.raises(MeshError, match="more than 5 parts"):
        read_mesh(by_hand(path, build='<item objectid="1"/>' * 6))


def test_points_are_refused_and_nothing_is_left(tmp_path):
    with pytest.raises(MeshError, match="triangles only"):
        write_mesh(tmp_path / "a.3mf", Mesh(CORNERS))
    assert not list(tmp_path.iterdir())


def test_without_the_library_its_extra_is_named(tmp_path, monkeypatch):
    write_mesh(tmp_path / "a.3mf", SCAN)
    monkeypatch.setitem(sys.modules, "lib3mf", None)
    for call in (lambda: read_mesh(tmp_path / "a.3mf"), lambda: write_mesh(tmp_path / "b.3mf", SCAN)):
        with pytest.raises(MeshError, match=r'\.3mf.*pip install "fusion-scan\[print\]"'):
            call()
    assert not (tmp_path / "b.3mf").exists()


def test_what_lies_farther_out_than_the_library_takes_is_told(tmp_path):
    """Not by the library's own words: a thing of 2000 km, in which 32 bits see no fault."""
    with pytest.raises(MeshError, match="3MF holds no coordinates so far"):
        write_mesh(tmp_path / "far.3mf", Mesh(CORNERS * 1e7, FACES))
