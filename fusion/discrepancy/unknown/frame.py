"""Frame of reference: to what a leftover is fixed, the sensor, the object, the table, time or what is measured."""

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from fusion.discrepancy.inference.shapes import surface
from fusion.discrepancy.inference.tile_covariance import TileCovariance
from fusion.discrepancy.naming.evidence import gain_elsewhere
from fusion.discrepancy.observe.observations import Observations

Vector = NDArray[np.float64]

MOST_CELLS = 160  # of each frame: more would tell recordings from each other
SHRINK = 0.5  # of the usual information of a cell: cells that few tiles fill tell little
CLEAR = 1.5  # times the gain of the next frame: less does not decide
SIGNAL = ("depth", "amplitude", "incidence")
WORDS = {
    "sensor": "it stays at the same pixels",
    "object": "it stays at the same places of the object",
    "table": "it comes back with the angle of the table",
    "time": "it comes with the time or the temperature",
    "signal": "it comes with the measured depth, brightness or angle, wherever that is in the image",
    "": "it stays at nothing that was tried: pixels, places of the object, time, measured values",
}


class LawFrame(Struct, frozen=True, kw_only=True):
    """To what an unknown law is tied."""

    name: Annotated[str, Meta(description="sensor, object, table, time, signal; empty: none predicts new recordings")]
    clear: Annotated[bool, Meta(description="false: the next one is nearly as good")]
    text: str


def frame_of(white: Vector, observations: Observations, covariance: TileCovariance) -> LawFrame:
    """The frame in which the mean of the leftover (n,) predicts recordings that took no part in it."""
    gains = {}
    for name, cells in _frames(observations):
        numbers = np.unique(cells, return_inverse=True)[1].ravel()
        columns = covariance.whiten(np.eye(int(np.max(numbers)) + 1)[numbers])
        gains[name] = gain_elsewhere(columns, white, observations.place, SHRINK)
    ranked = sorted(gains, key=lambda name: -gains[name])
    best = ranked[0] if ranked and gains[ranked[0]] > 0 else ""
    clear = len(ranked) < 2 or gains[ranked[0]] > CLEAR * max(gains[ranked[1]], 0.0)
    return LawFrame(
        name=best, clear=clear, text=WORDS[best] + ("" if clear or not best else ", as far as these recordings tell")
    )


def _frames(observations: Observations) -> Iterator[tuple[str, NDArray[np.intp]]]:
    """Name of each frame and the cell (n,) of every tile in it."""
    camera = observations.patches[0].view.camera
    side = max(16.0, np.sqrt(camera.width * camera.height / MOST_CELLS))
    known = observations.variables
    if "u" in known and "v" in known:
        yield "sensor", _grid([known["u"], known["v"]], side)
    shapes = {patch.block.stage.shape for patch in observations.patches if hasattr(patch.block.stage, "shape")}
    if len(shapes) == 1 and len(observations.patches) > 1:
        yield "object", _surface(observations)
    if "table_angle" in known:
        yield "table", np.asarray(np.mod(known["table_angle"], 2 * np.pi) / (2 * np.pi) * 24, np.intp)
    for name in ("temperature", "time"):
        if name in known:
            yield "time", _quantiles(known[name], 10)
            break
    signal = [_quantiles(known[name], 6 if name == "depth" else 4) for name in SIGNAL if name in known]
    if signal:
        yield "signal", np.asarray(sum(cell * 10**k for k, cell in enumerate(signal)), np.intp)


def _surface(observations: Observations) -> NDArray[np.intp]:
    """Cells of the object's surface, in its own frame."""
    where = np.concatenate([surface(patch)[0] for patch in observations.patches])
    spans = np.ptp(where, axis=0)
    # a surface: two of the three directions count
    side = float(np.sqrt(np.prod(np.sort(spans)[1:]) / MOST_CELLS))
    return _grid(list(where.T), max(side, 1e-3))


def _grid(axes: list[Vector], side: float) -> NDArray[np.intp]:
    out = np.zeros(len(axes[0]), np.intp)
    for values in axes:
        out = out * 1000 + np.asarray((values - np.min(values)) / side, np.intp)
    return out


def _quantiles(values: Vector, count: int) -> NDArray[np.intp]:
    edges = np.unique(np.quantile(values, np.linspace(0, 1, count + 1)))
    return np.asarray(np.searchsorted(edges[1:-1], values, side="right"), np.intp)
