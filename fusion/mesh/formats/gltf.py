"""GLB and glTF: read by trimesh, after what trimesh believes has been looked at."""

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from fusion.errors import MeshError
from fusion.files.inside import inside
from fusion.files.limits import check_size
from fusion.files.reading import decoded, read_bytes
from fusion.mesh.exchange import from_trimesh
from fusion.mesh.mesh import Mesh

JSON, BINARY = 0x4E4F534A, 0x004E4942
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_")  # what does not change the surface
LINES, TRIANGLES = (1, 2, 3), (4, 5)  # modes of a primitive that trimesh reads; 5: strips


class Beside:
    """What a glTF file names, from beside it and from nowhere else: what trimesh calls a resolver."""

    def __init__(self, path: Path) -> None:
        self.folder, self.path = path.parent, path

    def __getitem__(self, name: str) -> bytes:
        return read_bytes(inside(self.folder, name, MeshError, self.path), MeshError, "a part of the mesh")

    get = __getitem__


def read_gltf(data: bytes, path: Path) -> Mesh:
    """One mesh of all that the scene shows, in its place."""
    import trimesh

    binary = path.suffix.lower() == ".glb"
    tree = _glb_header(data) if binary else _json(data)
    _check(tree, path)
    loaded = trimesh.load(
        io.BytesIO(data),
        file_type=path.suffix.lower()[1:],
        resolver=Beside(path),  # type: ignore[arg-type]
        process=False,
        skip_materials=True,
    )
    return from_trimesh(loaded)


def _json(data: bytes) -> dict[str, Any]:
    try:
        tree = json.loads(decoded(data))
    except RecursionError:
        raise ValueError("JSON nested too deeply") from None
    if not isinstance(tree, dict):
        raise ValueError("no JSON object")
    return tree


def _glb_header(data: bytes) -> dict[str, Any]:
    """The JSON of a container whose lengths are right."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise ValueError(f"no GLB header: {data[:8]!r}")
    version, length, first, kind = struct.unpack("<IIII", data[4:20])
    if version != 2 or kind != JSON:
        raise ValueError(f"GLB version {version}" if version != 2 else "no JSON at its start")
    if length != len(data):
        raise ValueError(f"{len(data)} of {length} bytes")
    at = 12
    while at < length:
        if at + 8 > length or at + 8 + struct.unpack("<I", data[at : at + 4])[0] > length:
            raise ValueError(f"a part of the file that is cut off at byte {at}")
        at += 8 + struct.unpack("<I", data[at : at + 4])[0]
    return _json(data[20 : 20 + first])


def _check(tree: dict[str, Any], path: Path) -> None:
    try:
        needed = [name for name in tree.get("extensionsRequired", []) if not name.startswith(HARMLESS)]
        if needed:
            raise ValueError(f"the extension {str(needed[0])[:40]}, which is not read")
        sizes = [_accessor(tree, index) for index in range(len(tree.get("accessors", [])))]
        check_size(sum(sizes), path, MeshError, "the mesh")
        meshes = [_primitives(tree, mesh, sizes) for mesh in tree.get("meshes", [])]
        check_size(_shown(tree, meshes), path, MeshError, "the mesh")
    except (TypeError, AttributeError, KeyError, IndexError) as error:
        raise ValueError(f"a tree of parts that does not fit: {error!r}"[:120]) from error


def _accessor(tree: dict[str, Any], index: int) -> int:
    """Bytes of an array; ValueError where they are not in its view."""
    about = tree["accessors"][index]
    count, offset = about["count"], about.get("byteOffset", 0)
    row = NUMBERS[about["type"]] * BYTES[about["componentType"]]
    if not all(type(n) is int and n >= 0 for n in (count, offset)):
        raise ValueError(f"accessor {index} of {count!r} rows from {offset!r}")
    if "bufferView" in about:
        view = tree["bufferViews"][about["bufferView"]]
        there, stride = view["byteLength"], view.get("byteStride", row)
        numbers = (there, stride, view.get("byteOffset", 0), view["buffer"], about["bufferView"])
        if not all(type(n) is int and n >= 0 for n in numbers) or stride < 1:
            raise ValueError(f"bufferView {about['bufferView']} of {there!r} bytes")
        if count and offset + (count - 1) * stride + row > there:
            raise ValueError(f"accessor {index}: {count} rows in {there} bytes")
    return count * row


def _primitives(tree: dict[str, Any], mesh: dict[str, Any], sizes: list[int]) -> int:
    """Bytes of a mesh's arrays; ValueError where trimesh would leave faces out, or take zeros for numbers."""
    total = 0
    for one in mesh["primitives"]:
        mode = one.get("mode", 4)
        if mode not in (0, *LINES, *TRIANGLES):
            raise ValueError(f"faces of mode {str(mode)[:20]}, which are not read")
        places = [place for place in (one["attributes"].get("POSITION"), one.get("indices")) if place is not None]
        for place in places:
            about = tree["accessors"][place]
            if "bufferView" not in about or "sparse" in about or about.get("normalized"):
                raise ValueError(f"accessor {place}, which is packed in a way that is not read")
        if "indices" in one and mode == 4 and tree["accessors"][one["indices"]]["count"] % 3:
            raise ValueError("a number of corners that is no multiple of three")
        total += sum(sizes[place] for place in places)
    return total


def _shown(tree: dict[str, Any], meshes: list[int]) -> int:
    """Bytes of all that the scene shows; ValueError where a node hangs below two others, or below itself."""
    nodes, seen, total = tree.get("nodes", []), set(), 0
    scenes = tree.get("scenes", [])
    queue = list(scenes[tree.get("scene", 0)].get("nodes", [])) if scenes else []
    while queue:
        place = queue.pop()
        if type(place) is not int or not 0 <= place < len(nodes) or place in seen:
            raise ValueError(f"node {str(place)[:20]}, which is not there or stands in two places")
        seen.add(place)
        queue += nodes[place].get("children", [])
        if "mesh" in nodes[place]:
            total += meshes[nodes[place]["mesh"]]
        if "matrix" in nodes[place] and not np.isfinite(np.array(nodes[place]["matrix"], float)).all():
            raise ValueError(f"node {place}, whose matrix is not finite")
    return total
