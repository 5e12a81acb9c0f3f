"""An interactive 3D view of a mesh: plotly with its JavaScript inside the page, once."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fusion.geometry.pose import Array
from fusion.mesh.mesh import Mesh
from fusion.mesh.sight import sides
from fusion.report.page import Section
from fusion.report.palette import BLUE, GREY
from fusion.report.thinning import thinned


@dataclass(frozen=True)
class Layer:
    """One colouring of the mesh: colours (n, 3) uint8, or scalar values (n,) with a scale; neither is plain clay.

    Attributes:
        name: what the button says.
        colors: (n, 3) uint8 RGB, or None.
        values: (n,) shown through the scale, or None.
        unit: of the values.
        scale: plotly's name of the colour scale.
        low, high: values at the ends of the scale.
    """

    name: str
    colors: NDArray[np.uint8] | None = None
    values: NDArray | None = None
    unit: str = ""
    scale: str = "Viridis"
    low: float = 0.0
    high: float = 1.0


@dataclass(frozen=True)
class Path3D:
    """A line through space (n, 3) [m], with its name and colour; NaN breaks it."""

    name: str
    points: Array
    color: str


# plotly reads its text canvases back often and does not say so, for which browsers warn
_READ_OFTEN = """(() => {
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return get.call(this, kind, kind === "2d" ? {...options, willReadFrequently: true} : options);
  };
})();
"""


_BUTTONS = ["toImage", "zoom3d", "pan3d", "orbitRotation", "tableRotation", "resetCameraDefault3d"]


def script() -> str:
    """plotly's JavaScript, for Page.script: put it on a page once."""
    from plotly.offline import get_plotlyjs

    return _READ_OFTEN + get_plotlyjs()


def viewer(mesh: Mesh, layers: list[Layer], up: Array, front: Array, paths: tuple[Path3D, ...] = ()) -> Section:
    """The interactive view as a section; without content when the mesh is empty.

    Args:
        mesh: [m]; thinned out for display when it is large.
        layers: colourings of its vertices; the first is shown, buttons change it.
        up, front: (3,) directions in the mesh's frame; front points from the object to the eye.
        paths: lines that the legend switches on.
    """
    import plotly.graph_objects as go

    finite = np.isfinite(mesh.vertices).all(axis=1)
    if not finite.any():
        return Section("Turn it yourself")
    small, nearest = thinned(mesh)
    layers = layers or [Layer("Shape")]
    traces = [_trace(small, _at(layer, nearest), place == 0) for place, layer in enumerate(layers)]
    lines = [_line(path) for path in paths]
    figure = go.Figure([*traces, *lines])
    figure.update_layout(_layout(up, front, layers, len(lines)))
    inner = figure.to_html(
        full_html=False,
        include_plotlyjs=False,
        div_id="view3d",
        config={"displaylogo": False, "responsive": True, "scrollZoom": True, "modeBarButtons": [_BUTTONS]},
    )
    count = f"{len(small.faces):,} triangles" if len(small.faces) else f"{len(small.vertices):,} points"
    note = "" if len(small.faces) == len(mesh.faces) and len(mesh.faces) else f" Shown with {count} for speed."
    html = f'<div class="viewer" role="group" aria-label="Interactive 3D view of the mesh">{inner}</div>'
    html += "<noscript><p>The 3D view needs JavaScript; the pictures above do not.</p></noscript>"
    lead = f"Drag to turn, scroll to zoom, right-drag to shift. Axes in millimetres.{note}"
    return Section("Turn it yourself", lead, html=html, screen_only=True)


def _at(layer: Layer, nearest: NDArray[np.int64]) -> Layer:
    colors = None if layer.colors is None else layer.colors[nearest]
    values = None if layer.values is None else np.asarray(layer.values, np.float32)[nearest]
    return replace(layer, colors=colors, values=values)


def _trace(mesh: Mesh, layer: Layer, visible: bool) -> Any:
    """One colouring as a plotly trace [mm]."""
    import plotly.graph_objects as go

    x, y, z = (mesh.vertices.T * 1000).astype(np.float32)
    paint: dict[str, Any] = {"color": "#c9ced6"}
    if layer.values is not None:
        bar = {
            "title": {"text": layer.unit, "side": "right"},
            "thickness": 12,
            "len": 0.7,
            "outlinewidth": 0,
            "x": 0.99,
        }
        paint = {"colorscale": layer.scale, "cmin": layer.low, "cmax": layer.high, "colorbar": bar}
    if len(mesh.faces) == 0:
        marker = {"size": 2} | paint
        marker |= {"color": layer.values} if layer.values is not None else {}
        marker |= {"color": _hex(layer.colors)} if layer.colors is not None else {}
        return go.Scatter3d(x=x, y=y, z=z, mode="markers", marker=marker, visible=visible, name=layer.name)
    if layer.colors is not None:
        paint = {"vertexcolor": _hex(layer.colors)}
    if layer.values is not None:
        paint |= {"intensity": layer.values, "hovertemplate": f"%{{intensity:.2f}} {layer.unit}<extra></extra>"}
    else:
        paint |= {"hoverinfo": "none"}
    i, j, k = mesh.faces.T
    # painted values need flat light, a bare shape needs contrast
    soft = layer.values is not None or layer.colors is not None
    light = {"ambient": 0.8, "diffuse": 0.5} if soft else {"ambient": 0.55, "diffuse": 0.8}
    light |= {"specular": 0.06, "roughness": 0.8, "fresnel": 0.05}
    return go.Mesh3d(x=x, y=y, z=z, i=i, j=j, k=k, visible=visible, name=layer.name, lighting=light, **paint)


def _line(path: Path3D) -> Any:
    import plotly.graph_objects as go

    x, y, z = (path.points.T * 1000).astype(np.float32)
    return go.Scatter3d(
        x=x, y=y, z=z, mode="lines+markers", name=path.name, visible="legendonly", showlegend=True,
        line={"color": path.color, "width": 3}, marker={"color": path.color, "size": 2.5}, hoverinfo="name",
    )  # fmt: skip


def _hex(colors: NDArray[np.uint8]) -> list[str]:
    packed = colors.astype(np.uint32) @ np.array([65536, 256, 1], np.uint32)
    return [f"#{value:06x}" for value in packed.tolist()]


def _layout(up: Array, front: Array, layers: list[Layer], lines: int) -> dict[str, Any]:
    face, left, *_ = sides(up, front)
    eye = 1.65 * face.towards + 0.85 * left.towards + 0.7 * face.up
    axis = {"showbackground": False, "gridcolor": "#a9b1be", "zeroline": False, "color": "#8b94a3"}
    buttons = [
        {"label": layer.name, "method": "restyle", "args": ["visible", shown, list(range(len(layers)))]}
        for place, layer in enumerate(layers)
        for shown in [[place == other for other in range(len(layers))]]
    ]
    menu = {
        "type": "buttons", "direction": "right", "buttons": buttons, "x": 0.01, "y": 0.99, "xanchor": "left",
        "yanchor": "top", "bgcolor": "rgba(255,255,255,.92)", "bordercolor": "#8b94a3", "font": {"color": "#1c2330"},
        "pad": {"t": 4, "l": 4},
    }  # fmt: skip
    return {
        "scene": {
            "aspectmode": "data",
            "dragmode": "orbit",
            "camera": {"eye": dict(zip("xyz", eye.tolist(), strict=True)), "up": _xyz(face.up)},
            **{f"{name}axis": axis | {"title": {"text": f"{name} [mm]"}} for name in "xyz"},
        },
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": "Arial, sans-serif", "color": "#7b8596"},
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": GREY, "activecolor": BLUE},
        "showlegend": lines > 0,
        "legend": {"x": 0.01, "y": 0.02, "yanchor": "bottom", "bgcolor": "rgba(0,0,0,0)"},
        "updatemenus": [menu] if len(layers) > 1 else [],
    }


def _xyz(vector: Array) -> dict[str, float]:
    return dict(zip("xyz", map(float, vector), strict=True))
