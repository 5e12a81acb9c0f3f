"""GLB and glTF: lengths and the tree of parts, which trimesh believes; what a file names lies beside it."""

import struct
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct
from msgspec.json import decode

from fusion.errors import MeshError
from fusion.files.inside import inside
from fusion.files.limits import check_size
from fusion.files.reading import decoded, read_bytes

JSON = 0x4E4F534A
BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_")  # what does not change the surface
FANS = 6  # mode of a primitive, which trimesh leaves out
Count = Annotated[int, Meta(ge=0)]


class GltfView(Struct):
    byteLength: Count
    buffer: Count
    byteOffset: Count = 0
    byteStride: Annotated[int, Meta(ge=1)] | None = None


class Accessor(Struct):
    count: Count
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    componentType: Literal[5120, 5121, 5122, 5123, 5125, 5126]
    bufferView: Count | None = None
    byteOffset: Count = 0
    sparse: Any = None
    normalized: bool = False


class Primitive(Struct):
    attributes: dict[str, Count]
    indices: Count | None = None
    mode: Annotated[int, Meta(ge=0, le=6)] = 4


class GltfShape(Struct):  # what glTF calls a mesh
    primitives: list[Primitive]


class GltfNode(Struct):
    children: list[Count] = []
    mesh: Count | None = None
    matrix: list[float] = []  # msgspec takes no number that is not finite


class GltfScene(Struct):
    nodes: list[Count] = []


class GltfTree(Struct):
    accessors: list[Accessor] = []
    bufferViews: list[GltfView] = []
    meshes: list[GltfShape] = []
    nodes: list[GltfNode] = []
    scenes: list[GltfScene] = []
    scene: Count = 0
    extensionsRequired: list[str] = []


class NamedFiles:
    """What a glTF file names, from beside it and from nowhere else: what trimesh calls a resolver."""

    def __init__(self, path: Path) -> None:
        self.folder, self.path = path.parent, path

    def __getitem__(self, name: str) -> bytes:
        path = inside(self.folder, name, MeshError, self.path)
        return read_bytes(path, MeshError, f"a part of {self.path}")

    get = __getitem__


def check_gltf(data: bytes, path: Path) -> None:
    """ValueError where trimesh would take zeros for numbers, leave faces out, or need more than is there."""
    tree = decode(decoded(_json(data) if path.suffix.lower() == ".glb" else data), type=GltfTree)
    needed = [name for name in tree.extensionsRequired if not name.startswith(HARMLESS)]
    if needed:
        raise ValueError(f"the extension {needed[0][:40]}, which is not read")
    try:
        sizes = [_size(tree, place) for place in range(len(tree.accessors))]
        shapes = [sum(_size_of(tree, one, sizes) for one in shape.primitives) for shape in tree.meshes]
        check_size(sum(sizes) + _shown(tree, shapes), path, MeshError, "the mesh")
    except IndexError:
        raise ValueError("a part that names another which is not there") from None


def _json(data: bytes) -> bytes:
    """The JSON of a container whose lengths are right."""
    if len(data) < 20 or data[:4] != b"glTF":
        raise ValueError(f"no GLB header: {data[:8]!r}")
    version, length, first, kind = struct.unpack("<IIII", data[4:20])
    at = 12
    while at + 8 <= len(data):
        at += 8 + struct.unpack("<I", data[at : at + 4])[0]
    if (version, kind) != (2, JSON) or not at == length == len(data):
        raise ValueError(f"GLB version {version}; {len(data)} bytes of {length} promised, or of {at} in its parts")
    return data[20 : 20 + first]


def _size(tree: GltfTree, place: int) -> int:
    """Bytes of an array; ValueError where they are not in its view."""
    about = tree.accessors[place]
    row = NUMBERS[about.type] * BYTES[about.componentType]
    if about.bufferView is not None and about.count:
        view = tree.bufferViews[about.bufferView]
        if about.byteOffset + (about.count - 1) * (view.byteStride or row) + row > view.byteLength:
            raise ValueError(f"accessor {place}: {about.count} rows in {view.byteLength} bytes")
    return about.count * row


def _size_of(tree: GltfTree, one: Primitive, sizes: list[int]) -> int:
    """Bytes of a primitive; ValueError where it is of a kind that is not read."""
    if one.mode == FANS:
        raise ValueError(f"faces of mode {one.mode}, which are not read")
    places = [place for place in (one.attributes.get("POSITION"), one.indices) if place is not None]
    for about in (tree.accessors[place] for place in places):
        if about.bufferView is None or about.sparse is not None or about.normalized:
            raise ValueError("an accessor that is packed in a way that is not read")
    corners = one.attributes.get("POSITION")
    if corners is not None and tree.accessors[corners].type != "VEC3":
        raise ValueError(f"places of type {tree.accessors[corners].type} instead of VEC3")
    if one.indices is not None and tree.accessors[one.indices].type != "SCALAR":
        raise ValueError(f"corners of type {tree.accessors[one.indices].type} instead of SCALAR")
    if one.indices is not None and one.mode == 4 and tree.accessors[one.indices].count % 3:
        raise ValueError("a number of corners that is no multiple of three")
    return sum(sizes[place] for place in places)


def _shown(tree: GltfTree, shapes: list[int]) -> int:
    """Bytes of all that the scene shows; ValueError where a node hangs below two others, or below itself."""
    seen: set[int] = set()
    queue, total = list(tree.scenes[tree.scene].nodes) if tree.scenes else [], 0
    while queue:
        place = queue.pop()
        if place in seen:
            raise ValueError(f"node {place}, which stands in two places")
        seen.add(place)
        node = tree.nodes[place]
        queue += node.children
        total += shapes[node.mesh] if node.mesh is not None else 0
    return total
