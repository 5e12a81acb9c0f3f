"""Writers of every mesh format, by the formats' definitions, so that any part of a file can be made wrong."""

import io
import json
import struct
import zipfile
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Shape:
    """Vertices (n, 3) [m] and triangles (m, 3), counter-clockwise from outside."""

    vertices: np.ndarray
    faces: np.ndarray


def cube(edge: float = 0.2) -> Shape:
    """A cube about the origin."""
    v = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) * edge / 2
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Shape(v, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def ball(steps: int = 24, radius: float = 0.1) -> Shape:
    """A sphere of two poles and rings: enough points to align."""
    rings = [np.array([[0, 0, -radius]])]
    around = np.linspace(0, 2 * np.pi, 2 * steps, endpoint=False)
    for up in np.linspace(-np.pi / 2, np.pi / 2, steps + 1)[1:-1]:
        ring = [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.full(len(around), np.sin(up))]
        rings += [radius * np.column_stack(ring)]
    v = np.vstack([*rings, [[0, 0, radius]]])
    n, last = 2 * steps, len(v) - 1
    at = lambda ring, k: 1 + ring * n + k % n  # noqa: E731
    faces = [[0, at(0, k + 1), at(0, k)] for k in range(n)]
    faces += [[last, at(steps - 2, k), at(steps - 2, k + 1)] for k in range(n)]
    for ring in range(steps - 2):
        for k in range(n):
            faces += [
                [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)],
                [at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)],
            ]
    return Shape(v, np.array(faces))


def ply_header(kind: str, vertices: int | str, faces: int | str, extra: str = "") -> bytes:
    """A header as most programs write it."""
    return (
        f"ply\nformat {kind} 1.0\nelement vertex {vertices}\n"
        f"property float x\nproperty float y\nproperty float z\n{extra}"
        f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()


def ply_ascii(shape: Shape) -> bytes:
    rows = [" ".join(f"{x:.6g}" for x in p) for p in shape.vertices] + [
        "3 " + " ".join(map(str, f)) for f in shape.faces
    ]
    return ply_header("ascii", len(shape.vertices), len(shape.faces)) + "\n".join(rows).encode() + b"\n"


def ply_binary(shape: Shape, order: str = "<") -> bytes:
    kind = "binary_little_endian" if order == "<" else "binary_big_endian"
    body = shape.vertices.astype(f"{order}f4").tobytes()
    body += b"".join(struct.pack(f"{order}B3i", 3, *map(int, f)) for f in shape.faces)
    return ply_header(kind, len(shape.vertices), len(shape.faces)) + body


def pcd_header(points: int | str, data: str, fields: str = "x y z", size: str = "4 4 4", kind: str = "F F F") -> bytes:
    return (
        f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {fields}\nSIZE {size}\nTYPE {kind}\n"
        f"COUNT {' '.join('1' for _ in fields.split())}\n"
        f"WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\n"
        f"DATA {data}\n"
    ).encode()


def pcd_ascii(shape: Shape) -> bytes:
    rows = "\n".join(" ".join(f"{x:.6g}" for x in p) for p in shape.vertices)
    return pcd_header(len(shape.vertices), "ascii") + rows.encode() + b"\n"


def pcd_binary(shape: Shape) -> bytes:
    return pcd_header(len(shape.vertices), "binary") + shape.vertices.astype("<f4").tobytes()


def xyz(shape: Shape) -> bytes:
    return ("\n".join(" ".join(f"{x:.6g}" for x in p) for p in shape.vertices) + "\n").encode()


def obj(shape: Shape) -> bytes:
    rows = ["v " + " ".join(f"{x:.6g}" for x in p) for p in shape.vertices]
    rows += ["f " + " ".join(str(i + 1) for i in f) for f in shape.faces]
    return ("\n".join(rows) + "\n").encode()


def off(shape: Shape) -> bytes:
    rows = ["OFF", f"{len(shape.vertices)} {len(shape.faces)} 0"]
    rows += [" ".join(f"{x:.6g}" for x in p) for p in shape.vertices] + [
        "3 " + " ".join(map(str, f)) for f in shape.faces
    ]
    return ("\n".join(rows) + "\n").encode()


def stl_ascii(shape: Shape) -> bytes:
    rows = ["solid cube"]
    for face in shape.faces:
        corners = [f"vertex {x:.6g} {y:.6g} {z:.6g}" for x, y, z in shape.vertices[face]]
        rows += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    return ("\n".join([*rows, "endsolid cube"]) + "\n").encode()


def stl_binary(shape: Shape) -> bytes:
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *shape.vertices[f].ravel(), 0) for f in shape.faces)
    return b"made for a test".ljust(80) + struct.pack("<I", len(shape.faces)) + body


def glb_json(shape: Shape) -> tuple[dict, bytes]:
    """The two chunks of a GLB file: its JSON, and its binary part."""
    points, indices = shape.vertices.astype("<f4").tobytes(), shape.faces.astype("<u4").tobytes()
    told = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(shape.vertices),
                "type": "VEC3",
                "min": shape.vertices.min(0).tolist(),
                "max": shape.vertices.max(0).tolist(),
            },
            {"bufferView": 1, "componentType": 5125, "count": shape.faces.size, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(indices)},
        ],
        "buffers": [{"byteLength": len(points) + len(indices)}],
    }
    return told, points + indices


def glb_file(told: dict | bytes, body: bytes) -> bytes:
    text = told if isinstance(told, bytes) else json.dumps(told).encode()
    text += b" " * (-len(text) % 4)
    body += b"\0" * (-len(body) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def glb(shape: Shape) -> bytes:
    return glb_file(*glb_json(shape))


def threemf(shape: Shape) -> bytes:
    """Millimetres, of one part; the least that the core specification asks for."""
    corners = "".join(f'<vertex x="{x:.6g}" y="{y:.6g}" z="{z:.6g}"/>' for x, y, z in 1000 * shape.vertices)
    sides = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in shape.faces)
    model = (
        '<?xml version="1.0"?><model unit="millimeter" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">'
        f"<mesh><vertices>{corners}</vertices><triangles>{sides}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>'
    )
    kinds = (
        '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
    )
    relations = (
        '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        '<Relationship Target="/3D/3dmodel.model" Id="r" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
    )
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as file:  # as they are: a changed byte meets the XML
        for name, text in (("[Content_Types].xml", kinds), ("_rels/.rels", relations), ("3D/3dmodel.model", model)):
            file.writestr(zipfile.ZipInfo(name), text)
    return made.getvalue()


# every format that is read, by the name's end; two kinds of one format have names of their own
GOOD = {
    "ascii.ply": ply_ascii,
    "little.ply": ply_binary,
    "big.ply": lambda shape: ply_binary(shape, ">"),
    "ascii.pcd": pcd_ascii,
    "binary.pcd": pcd_binary,
    "points.xyz": xyz,
    "cube.obj": obj,
    "cube.off": off,
    "ascii.stl": stl_ascii,
    "binary.stl": stl_binary,
    "cube.glb": glb,
    "cube.3mf": threemf,
}
