"""The part of the mesh that one tile gives."""

import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from fusion.mesh.cleanup import parts
from fusion.mesh.mesh import Mesh
from fusion.tiles.tile import Tile
from fusion.volume.extraction.surface import Extracted
from fusion.volume.settings import BLOCK
from fusion.volume.volume import Volume


@dataclass(frozen=True)
class Piece:
    """Faces whose cell a tile owns, and vertices whose edge begins at a voxel that it owns."""

    vertices: NDArray[np.float64]  # (n, 3) float64 [m], owned
    normals: NDArray[np.float32]  # (n, 3) float32
    faces: NDArray[np.int32]  # (m, 3) int32; n and more stand for the k vertices of the faces that other tiles own
    seam: NDArray[np.int32]  # (s,) int32 owned vertices that other tiles' faces may use
    seam_keys: NDArray[np.int32]  # (s, 4) int32 voxel and axis of their edges, which name them
    foreign_keys: NDArray[np.int32]  # (k, 4) int32 of vertices that other tiles own
    part: NDArray[np.int32]  # (n + k,) int32 connected part of each vertex, foreign ones behind
    # low, high: (p, 3) float64 box around each part [m]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    area: NDArray[np.float64]  # (p,) float64 of its faces [m^2]

    def save(self, path: Path) -> None:
        """As .npz."""
        np.savez(path, **vars(self))


@dataclass(frozen=True, order=True)
class Filed:
    """A piece in its file: its arrays are read one by one, as they are needed."""

    tile: Tile
    path: Path

    def array(self, name: str) -> NDArray:
        """One of the piece's arrays."""
        with np.load(self.path) as file:
            return np.asarray(file[name])

    def count(self, name: str) -> int:
        """Its length, without reading it."""
        with zipfile.ZipFile(self.path) as file, file.open(f"{name}.npy") as part:
            npy.read_magic(part)
            return int(npy.read_array_header_1_0(part)[0][0])


def piece_of(volume: Volume, tile: Tile, found: Extracted) -> Piece:
    """The part of a surface, extracted from a tile with its halo, that is the tile's own."""
    block, place, axis, cell = found.edges()
    coordinates = volume.blocks.coordinates[: volume.block_count]
    core = tile.holds(coordinates)
    faces = found.mesh.faces[core[cell]]
    own = core[block] if len(block) else np.zeros(0, bool)
    foreign = np.zeros(len(own), bool)
    foreign[faces.ravel()] = True
    foreign &= ~own
    order = np.concatenate([np.flatnonzero(own), np.flatnonzero(foreign)])
    number = np.full(len(own), -1, np.int32)
    number[order] = np.arange(len(order))
    voxel = np.stack([place // BLOCK**2, place // BLOCK % BLOCK, place % BLOCK], axis=1)
    keys = np.column_stack([coordinates[block] * BLOCK + voxel, axis]).astype(np.int32)[order]
    n = int(own.sum())
    seam = np.flatnonzero((keys[:n, :3] == np.multiply(tile.low, BLOCK)).any(axis=1)).astype(np.int32)
    mesh = Mesh(found.mesh.vertices[order], number[faces])
    part, area = parts(mesh) if len(faces) else (np.arange(len(order), dtype=np.int32), np.zeros(len(order)))
    low, high = np.full((len(area), 3), np.inf), np.full((len(area), 3), -np.inf)
    np.minimum.at(low, part, mesh.vertices)
    np.maximum.at(high, part, mesh.vertices)
    normals = found.mesh.normals
    assert normals is not None
    return Piece(
        mesh.vertices[:n], normals[order[:n]], mesh.faces, seam, keys[seam], keys[n:], part, low, high, area
    )  # fmt: skip
