"""Every format of docs/formats.md: how the scene goes into it, who writes it, and what real file of it is at hand."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from tools.formats import files, folders
from tools.formats.boxes import ramp, taken
from tools.formats.take import Lens, Take, save
from tools.formats.writers import azure, openni, orbbec, phones, ros, scannet, xef_check
from tools.formats.writers.programs import Tools, by_debian, elsewhere

# numbers that single precision holds; the principal point is far from the middle in both directions
PLAIN = Lens(320, 240, 287.5, 291.25, 141.25, 128.5)
LARGE = Lens(640, 480, 575.5, 583.0, 296.75, 259.25)
LIDAR = Lens(256, 192, 213.5, 212.25, 119.75, 101.5)
SEVEN = Lens(640, 480, 585.0, 585.0, 320.0, 240.0)
KINECT2 = Lens(512, 424, 365.5, 366.25, 261.0, 198.5)
APART = Lens(320, 200, 250.5, 252.25, 171.5, 92.75, (0.06, -0.09, 0.0015, -0.001, 0.02, 0.0, 0.0, 0.0))
SIX = replace(APART, bend=(0.06, -0.09, 0.0015, -0.001, 0.02, 0.01, -0.02, 0.004))
RATIONAL = replace(PLAIN, bend=(0.52, -0.11, 0.0012, -0.0008, 0.02, 0.86, 0.05, 0.01))
OWN = "from its description"


@dataclass(frozen=True)
class Case:
    """One row: `said` is what a user would say with --camera; `foreign` a real file of the format."""

    name: str
    writer: str
    take: Take
    write: Callable[[Take, Path], Path]
    said: str | None = None
    foreign: str = ""
    clock: bool = True  # whether the format has one


def apart(take: Take, lens: Lens) -> Take:
    """With colour of a second camera beside the depth camera."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", [1.5, -2.0, 3.0], degrees=True).as_matrix()
    T[:3, 3] = [-0.0325, 0.004, 0.0025]
    return replace(
        take, color=np.stack([ramp(lens, i) for i in range(len(take.depth))]), color_lens=lens, T_color_depth=T
    )


def cases(tools: Tools) -> list[Case]:
    """All that can be written here."""
    plain, fine = taken(PLAIN), taken(PLAIN, unit=0.0002)
    four = ",".join(map(str, PLAIN.four))
    video = taken(LIDAR)
    out = [
        Case("native", "by its description, cv2", fine, folders.native, foreign="kleenex_turntable"),
        Case("native, bent lens", "by its description, cv2", taken(RATIONAL), folders.native),
        Case("TUM RGB-D", OWN, plain, folders.tum, four, "tum_fr1_rpy"),
        Case("7-Scenes", OWN, taken(SEVEN), folders.seven_scenes, clock=False),
        Case("BOP", OWN, plain, folders.bop, clock=False),
        Case("fakenect", OWN + " (record.c)", still(LARGE), files.fakenect, said=of(LARGE)),
        Case("Open3D", "open3d's io", plain, folders.open3d),
        Case("Orbbec .bag", "rosbags, SDK's source", apart(taken(PLAIN, unit=0.0005, still=True), SIX), orbbec.bag),
        *bags(plain),
        Case("nerfstudio", OWN, plain, folders.nerfstudio, clock=False),
        Case("Record3D .r3d", "zipfile, lzfse", video, partial(phones.record3d, times=phones.TIMES)),
        Case("Polycam raw", "zipfile, cv2", video, phones.polycam),
        Case("Stray Scanner", "cv2, av", video, phones.stray),
        Case("ScanNet .sens", OWN, plain, files.sens),
        Case(".klg", OWN, still(LARGE), files.klg, of(LARGE)),
        Case("libfreenect2", OWN, still(KINECT2), files.freenect2, of(KINECT2), clock=False),
        *kinect_studio(tools),
        *planted(fine),
        Case("plain PNG", "cv2", still(PLAIN), folders.plain, four, clock=False),
        Case("plain NPY", "numpy", still(PLAIN), folders.arrays, four, clock=False),
    ]
    return out + foreign(tools)


def kinect_studio(tools: Tools) -> list[Case]:
    """Both kinds of `.xef`; neither cameras nor the colour's place are in them."""
    dark = replace(still(KINECT2), color=None)
    writer = OWN if tools.xef is None else "its reader agrees"
    kinds = (("Kinect Studio .xef", False, False), (".xef archived", True, False), (".xef with colour", False, True))
    return [
        Case(name, writer, dark, partial(xef_check.write, sources=tools.xef, archived=a, color=c), of(KINECT2))
        for name, a, c in kinds
    ]


def planted(take: Take) -> list[Case]:
    """Faults that the judge must see: it says `not reached` of all three."""

    def shifted(take: Take, path: Path) -> Path:
        return folders.native(take, path, cx=take.lens.cx + 0.5)

    def larger(take: Take, path: Path) -> Path:
        return folders.native(take, path, depth_scale=0.998 / take.unit)

    def mirrored(take: Take, path: Path) -> Path:
        lens = replace(take.lens, cx=take.lens.width - 1 - take.lens.cx)
        return folders.native(replace(take, depth=take.depth[:, :, ::-1], lens=lens), path)

    kinds = {"half a pixel": shifted, "0.2 % larger": larger, "mirrored": mirrored}
    return [Case(f"PLANTED {name}", "by its description, cv2", take, write) for name, write in kinds.items()]


def of(lens: Lens) -> str:
    """For --camera."""
    return ",".join(map(str, lens.four))


def still(lens: Lens) -> Take:
    """By a camera that never moves."""
    return taken(lens, still=True)


def bags(plain: Take) -> list[Case]:
    """rosbags' ways."""
    kinds = [
        ("ROS 1 .bag", "ros1", "16UC1", False),
        ("ROS 1 .bag 32FC1", "ros1", "32FC1", False),
        ("ROS 1 .bag LZ4", "ros1-lz4", "16UC1", False),
        ("ROS 2 SQLite", "sqlite3", "16UC1", False),
        ("ROS 2 MCAP 32FC1", "mcap", "32FC1", False),
        ("ROS 2 compressedDepth", "mcap", "16UC1", True),
    ]
    made = [
        Case(name, "rosbags 0.11", plain, partial(ros.bag, kind=kind, encoding=encoding, packed=packed))
        for name, kind, encoding, packed in kinds
    ]
    made.append(Case("ROS 2 rational lens", "rosbags 0.11", taken(RATIONAL), partial(ros.bag, kind="mcap")))
    return made


def foreign(tools: Tools) -> list[Case]:
    """What the makers' own programs write."""
    out = []
    steady = apart(taken(PLAIN, unit=0.0002, still=True), APART)
    for name, python, ending, words in (
        ("RealSense .bag", tools.bag, ".bag", ()), ("RealSense .db3", tools.db3, ".db3", ()),
        ("RealSense .db3 unpacked", tools.db3, ".db3", ("plain",)),
    ):  # fmt: skip
        if python is not None:
            writer = "pyrealsense2 " + ("2.56.5" if ending == ".bag" else "2.59.1")
            out.append(Case(name, writer, steady, partial(intel, python=python, ending=ending, words=words)))
    if tools.mcap is not None:
        write = partial(foxglove, python=tools.mcap)
        out.append(Case("bare MCAP", "mcap-ros2-support 0.6", still(PLAIN), write))
    if tools.rosbag is not None:
        for how in ("none", "lz4", "bz2"):
            write = partial(debian, root=tools.rosbag, how=how)
            out.append(Case(f"ROS 1 .bag, rosbag {how}", "Debian's rosbag 1.15", taken(PLAIN), write))
    if tools.k4a is not None:
        for mode in ("NFOV_2X2BINNED", "NFOV_UNBINNED", "WFOV_2X2BINNED") if tools.only in "Azure .mkv" else ():
            rays = azure.rays(tools.k4a, mode)
            take = replace(taken(azure.stated(mode), rays=rays, still=True), color=None)
            write = partial(azure_mkv, libraries=tools.k4a, mode=mode)
            out.append(Case(f"Azure .mkv {mode}", "libk4arecord 1.4", take, write, foreign="azure_kinect_mkv"))
    if tools.sens is not None:
        out.append(
            Case("ScanNet .sens, its own", "ScanNet's C++", taken(PLAIN), partial(scannet.write, sources=tools.sens))
        )
    if tools.oni is not None:
        write = partial(openni.write, root=tools.oni)
        out.append(Case(".oni", "OpenNI2's recorder", still(PLAIN), write, of(PLAIN), "samples/openni2_dummy.oni"))
        field = openni.of_field(320, 240, 1.0225, 0.7967)  # of a PrimeSense camera
        out.append(Case(".oni, its field of view", "OpenNI2's recorder", still(field), write))
    return out


def intel(take: Take, path: Path, python: Path, ending: str, words: tuple[str, ...]) -> Path:
    """By the SDK."""
    return elsewhere(python, "realsense.py", save(take, path.with_suffix(".npz")), path.with_suffix(ending), *words)


def foxglove(take: Take, path: Path, python: Path) -> Path:
    """By Foxglove's library."""
    return elsewhere(python, "foxglove_mcap.py", save(take, path.with_suffix(".npz")), path.with_suffix(".mcap"))


def azure_mkv(take: Take, path: Path, libraries: Path, mode: str) -> Path:
    """By Microsoft's library."""
    return azure.write(take, path.with_suffix(".mkv"), libraries, mode)


def debian(take: Take, path: Path, root: Path, how: str) -> Path:
    """By ROS 1's own library."""
    return by_debian(root, "debian_rosbag.py", save(take, path.with_suffix(".npz")), path.with_suffix(".bag"), how)
