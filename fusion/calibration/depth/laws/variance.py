"""How large the errors of a tile are: from what a rich law leaves over, not from the count of pixels."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fusion.calibration.depth.laws.information import WallEvidence
from fusion.calibration.depth.walls.tiles import TileGrid
from fusion.geometry.robust import robust_std

FLAT = 2e-4  # [m] how far a tile of a good wall may stand off its plane (guess)
FEW = 24  # tiles whose spread is known to a fifth: as good as what all walls together say (guess)
BLOCK = 4  # tiles across a block, over which errors are no longer alike (guess)


def with_variance(evidence: WallEvidence, rest: NDArray[np.floating], usual: float) -> WallEvidence:
    """The evidence with the variance that `rest` (t,) [m], after a rich law and the nuisances, shows.

    Neighbouring tiles that err alike count for fewer: the variance grows by how much slower their means settle.

    Args:
        usual: spread of the tiles on a usual wall [m]: a few tiles (squares of a board) tell their own badly.
    """
    share = FEW / (FEW + len(rest))
    spread = float(np.sqrt((1 - share) * spread_of(rest) ** 2 + share * usual**2))
    variance = np.maximum(evidence.variance, max(spread, FLAT) ** 2)
    return replace(evidence, variance=variance * alike(evidence.tiles, rest))


def spread_of(rest: NDArray[np.floating]) -> float:
    """Robust standard deviation [m] of what is left on the tiles of a wall (t,)."""
    return robust_std(rest - np.median(rest))


def alike(tiles: TileGrid, rest: NDArray[np.floating]) -> float:
    """Factor by which the mean over a block of tiles varies more than if the tiles were independent, 1 to 16."""
    image = tiles.image(rest)
    rows, columns = (n // BLOCK * BLOCK for n in image.shape)
    if rows == 0 or columns == 0:
        return 1.0
    split = image[:rows, :columns].reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).swapaxes(1, 2)
    blocks = split.reshape(-1, BLOCK * BLOCK)
    full = blocks[np.isfinite(blocks).all(axis=1)]
    single = float(np.var(rest))
    if len(full) < 4 or single == 0:
        return 1.0
    return float(np.clip(BLOCK**2 * np.mean(full.mean(axis=1) ** 2) / single, 1.0, BLOCK**2))
