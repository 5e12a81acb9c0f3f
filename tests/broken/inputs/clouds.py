"""PCD, XYZ and OBJ."""

import struct
from collections.abc import Iterator

from broken import meshes
from broken.case import EITHER, REFUSED
from broken.inputs.ply import Broken, shortened
from broken.meshes import (
    cube,
    pcd_ascii,
    pcd_binary,
    pcd_header,
)


def clouds() -> Iterator[Broken]:
    """PCD and XYZ."""
    box = cube()
    text, binary = pcd_ascii(box), pcd_binary(box)
    yield "POINTS 3 and one line ascii.pcd", pcd_header(3, "ascii") + b"1 2 3\n", REFUSED
    yield "POINTS 3 and no line ascii.pcd", pcd_header(3, "ascii"), REFUSED
    yield "two numbers in a line ascii.pcd", pcd_header(2, "ascii") + b"1 2 3\n4 5\n", REFUSED
    yield "a word ascii.pcd", pcd_header(2, "ascii") + b"1 2 3\n4 five 6\n", REFUSED
    yield "nan ascii.pcd", pcd_header(2, "ascii") + b"1 2 3\nnan nan nan\n", EITHER
    yield "every point nan ascii.pcd", pcd_header(2, "ascii") + b"nan nan nan\nnan nan nan\n", REFUSED
    for count in ("1000000000", "-1", "1.5", "many", "9" * 400, "0"):
        yield (
            f"POINTS {shortened(count)} ascii.pcd",
            text.replace(b"POINTS 8", b"POINTS " + count.encode()).replace(b"WIDTH 8", b"WIDTH " + count.encode()),
            REFUSED,
        )
        yield (
            f"POINTS {shortened(count)} binary.pcd",
            binary.replace(b"POINTS 8", b"POINTS " + count.encode()).replace(b"WIDTH 8", b"WIDTH " + count.encode()),
            REFUSED,
        )
    yield "WIDTH disagrees ascii.pcd", text.replace(b"WIDTH 8", b"WIDTH 5"), EITHER
    yield "no x ascii.pcd", pcd_header(1, "ascii", "a b c") + b"1 2 3\n", REFUSED
    yield "no FIELDS ascii.pcd", text.replace(b"FIELDS x y z\n", b""), REFUSED
    yield "unknown DATA ascii.pcd", text.replace(b"DATA ascii", b"DATA magic"), REFUSED
    yield "DATA compressed binary.pcd", binary.replace(b"DATA binary", b"DATA binary_compressed"), REFUSED
    yield (
        "compressed claims 4 GB binary.pcd",
        pcd_header(8, "binary_compressed") + struct.pack("<II", 10, 2**32 - 1) + bytes(10),
        REFUSED,
    )
    yield (
        "compressed of 10^9 binary.pcd",
        pcd_header(10**9, "binary_compressed") + struct.pack("<II", 10, 12 * 10**9 % 2**32) + bytes(10),
        REFUSED,
    )
    yield "size 3 binary.pcd", pcd_header(8, "binary", size="3 3 3") + bytes(96), REFUSED
    yield "size 10^9 binary.pcd", pcd_header(8, "binary", size="1000000000 4 4") + bytes(96), REFUSED
    yield "type Q binary.pcd", pcd_header(8, "binary", kind="Q Q Q") + bytes(96), REFUSED
    yield "count -1 binary.pcd", binary.replace(b"COUNT 1 1 1", b"COUNT -1 1 1"), REFUSED
    yield "count 10^9 binary.pcd", binary.replace(b"COUNT 1 1 1", b"COUNT 1000000000 1 1"), REFUSED
    for name, content in {
        "two numbers": b"1 2\n3 4\n",
        "a word": b"1 2 3\nx y z\n",
        "ragged": b"1 2 3\n4 5 6 7 8\n",
        "nan": b"nan nan nan\n",
        "commas": b"1,2,3\n4,5,6\n",
        "comments alone": b"# none\n",
        "1e300": b"1e300 0 0\n1 2 3\n",
        "JSON": b"{}",
    }.items():
        yield f"{name} points.xyz", content, REFUSED if name not in ("ragged", "commas") else EITHER


def objs() -> Iterator[Broken]:
    """OBJ counts from 1, or back from the last by negative numbers."""
    good = meshes.obj(cube())
    for name, face in {
        "0 1 2": b"0 1 2",
        "9": b"1 2 9",
        "-9": b"-1 -2 -9",
        "10^20": b"1 2 99999999999999999999",
        "a word": b"a b c",
        "1.5": b"1.5 2 3",
        "two corners": b"1 2",
        "10^9": b"1 2 1000000000",
    }.items():
        yield f"f {name} cube.obj", good + b"f " + face + b"\n", REFUSED
    for name, row in {
        "one number": b"v 1",
        "no number": b"v",
        "a word": b"v a b c",
        "nan": b"v nan 0 0",
        "inf": b"v inf 0 0",
        "400 digits": b"v " + b"9" * 400 + b" 0 0",
    }.items():
        yield f"last v {name} cube.obj", good + row + b"\n", EITHER if name in ("nan", "inf", "400 digits") else REFUSED
    yield "texture 0 cube.obj", good + b"vt 0 0\nf 1/0/0 2/0/0 3/0/0\n", EITHER
    yield "mtllib out cube.obj", b"mtllib ../outside/mesh.ply\nusemtl x\n" + good, EITHER
    yield "mtllib /dev/zero cube.obj", b"mtllib /dev/zero\nusemtl x\n" + good, EITHER
    yield "mtllib with escape codes cube.obj", b"mtllib \x1b[31mred.mtl\nusemtl x\n" + good, EITHER
    yield "vertices alone cube.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", EITHER
    yield "faces alone cube.obj", b"f 1 2 3\n", REFUSED
    yield "a line of 20 MB cube.obj", good + b"f " + b"1 2 3 " * 3_000_000 + b"\n", EITHER
    yield "a face of 5000 corners cube.obj", good + b"f " + b"1 2 3 " * 1700 + b"\n", EITHER
