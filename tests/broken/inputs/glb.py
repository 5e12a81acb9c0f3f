"""glTF's binary form: counts, offsets and addresses in its JSON."""

import json
import struct
from collections.abc import Iterator

from broken.case import EITHER, REFUSED
from broken.inputs.ply import Broken
from broken.meshes import (
    cube,
    glb_file,
    glb_json,
)


def glbs() -> Iterator[Broken]:
    """glTF's binary form: counts, offsets and addresses in its JSON."""
    told, body = glb_json(cube())
    whole = glb_file(told, body)

    def changed(*path: str | int, value: object) -> bytes:
        copy = json.loads(json.dumps(told))
        inner = copy
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value
        return glb_file(copy, body)

    yield "count 10^9 cube.glb", changed("accessors", 0, "count", value=10**9), REFUSED
    yield "count -1 cube.glb", changed("accessors", 0, "count", value=-1), REFUSED
    yield "indices 10^9 cube.glb", changed("accessors", 1, "count", value=3 * 10**9), REFUSED
    yield "offset beyond cube.glb", changed("bufferViews", 1, "byteOffset", value=10**9), REFUSED
    yield "offset -5 cube.glb", changed("bufferViews", 0, "byteOffset", value=-5), REFUSED
    yield "view 9 cube.glb", changed("accessors", 0, "bufferView", value=9), REFUSED
    yield "component 9 cube.glb", changed("accessors", 0, "componentType", value=9), REFUSED
    yield "VEC2 cube.glb", changed("accessors", 0, "type", value="VEC2"), REFUSED
    yield "node of itself cube.glb", changed("nodes", 0, value={"mesh": 0, "children": [0]}), REFUSED
    yield "mesh 7 cube.glb", changed("nodes", 0, "mesh", value=7), REFUSED
    yield (
        "a file outside cube.glb",
        changed("buffers", 0, value={"byteLength": 100, "uri": "/etc/passwd"}),
        REFUSED,
    )
    yield (
        "a web address cube.glb",
        changed("buffers", 0, value={"byteLength": 100, "uri": "http://127.0.0.1:9/x.bin"}),
        REFUSED,
    )
    yield "no meshes cube.glb", changed("meshes", value=[]), REFUSED
    yield (
        "scale nan cube.glb",
        glb_file(json.dumps(told).replace('{"mesh": 0}', '{"mesh": 0, "scale": [NaN, 1, 1]}').encode(), body),
        REFUSED,
    )
    yield "a list cube.glb", glb_file(b"[]", body), REFUSED
    yield "100,000 lists cube.glb", glb_file(b"[" * 100_000, body), REFUSED
    yield "length 4 GB cube.glb", whole[:8] + b"\xff\xff\xff\xff" + whole[12:], EITHER
    yield "chunk of 4 GB cube.glb", whole[:12] + b"\xff\xff\xff\xff" + whole[16:], REFUSED
    yield "version 9 cube.glb", whole[:4] + struct.pack("<I", 9) + whole[8:], REFUSED
    outside = cube().faces.astype("<u4")
    outside[0, 0] = 99
    yield "index 99 cube.glb", glb_file(told, cube().vertices.astype("<f4").tobytes() + outside.tobytes()), REFUSED
