"""A recording whose volume does not fit into memory: an overview in voxels that fit, then the mesh tile by tile."""

import shutil
from dataclasses import dataclass, replace
from pathlib import Path

from fusion.errors import VolumeError
from fusion.progress import stage
from fusion.quantity import VOXEL
from fusion.reconstruction.pipeline import CRUMB, reconstruct
from fusion.reconstruction.planning import plan
from fusion.reconstruction.result import Reconstruction
from fusion.reconstruction.settings import ReconstructSettings
from fusion.reconstruction.walk import WalkedFrames
from fusion.recording.recording import Recording
from fusion.results.light import Light
from fusion.sensor.correction.corrected_recording import corrected_recording
from fusion.sensor.presets import default_sensor
from fusion.tiles.fusing import Way, one_by_one, pieces
from fusion.tiles.stream import Streamed, stream
from fusion.volume.blocks import FullError
from fusion.volume.settings import VolumeSettings

# shares of the process's memory: libraries take some 0.5 GB, a tile up to five times its voxels while it grows and
# its surface is extracted (measured), and of an overview mesh, pictures and page many times its voxels
TILE, OVERVIEW, TRACKED = 16, 12, 8
UNBOUNDED = 1 << 60  # bytes


@dataclass(frozen=True)
class Large:
    """What became of it."""

    overview: Reconstruction  # a reconstruction in larger voxels: poses, judgement and page come from it
    # voxel, truncation: of the mesh that was written [m]
    voxel: float
    truncation: float
    mesh: Streamed  # how large that is
    tiles: int  # pieces that it was made of


def reconstruct_large(
    recording: Recording, settings: ReconstructSettings, memory: int, path: Path, way: Way = one_by_one
) -> Large:
    """Reconstruct a recording whose volume may be larger than memory; its mesh is written as PLY.

    Every block comes out as it would in one volume, and so does the mesh, bit for bit, for the same poses. It has
    normals; colours and standard deviations only the overview has.

    Args:
        memory: what a process may take [bytes], about.
        path: of the mesh; pieces lie in a folder beside it while it is made.
        way: how tiles are done.

    Raises:
        FusionError: as `reconstruct`; VolumeError too where not even an overview fits.
    """
    sensor = settings.sensor or default_sensor(recording.camera)
    corrected, _ = corrected_recording(recording, sensor)
    with stage("planning"):
        chosen = plan(corrected, replace(settings, max_bytes=UNBOUNDED), sensor)
    overview = _overview(recording, replace(settings, room=chosen.subject.room, box=chosen.volume.bounds),
                         chosen.volume.voxel, memory)  # fmt: skip
    volume = replace(chosen.volume, max_bytes=memory // TILE)
    frames = WalkedFrames(corrected, sensor, settings.max_depth)
    folder = path.with_name("tiles")
    folder.mkdir()
    try:
        found = pieces(frames, overview.trajectory.poses, volume, folder, way)
        mesh = stream(found, path, CRUMB * volume.truncation)
    finally:
        shutil.rmtree(folder)
    return Large(_told(overview, volume, mesh), volume.voxel, volume.truncation, mesh, len(found))


def _overview(recording: Recording, settings: ReconstructSettings, voxel: float, memory: int) -> Reconstruction:
    room = memory // (TRACKED if settings.poses is None else OVERVIEW)
    while voxel <= VOXEL.high:
        try:
            return reconstruct(recording, replace(settings, voxel=voxel, truncation=None, max_bytes=room))
        except FullError:
            voxel *= 2
    raise VolumeError(
        "not even an overview fits into memory", recording.path, f"voxels of {voxel:g} m do not",
        f"{room / 2**20:.0f} MiB are enough", "allow more (--memory), or leave out what is far (--max-depth, --box)",
    )  # fmt: skip


def _told(overview: Reconstruction, volume: VolumeSettings, mesh: Streamed) -> Reconstruction:
    coarse = overview.settings.voxel_m
    text = f"mesh.ply has voxels of {1e3 * volume.voxel:g} mm and {mesh.faces:,} triangles. "
    text += f"Numbers and pictures here are those of an overview in voxels of {1e3 * coarse:g} mm."
    # what the overview takes of its small share of the memory is nothing that a person could act on
    others = [light for light in overview.notes if not light.reason.startswith("Memory: ")]
    return replace(overview, notes=(*others, Light("ok", "Overview", text)))
