"""How sure each part of a surface is: its standard deviation along the normal, in colours [mm]."""

from collections.abc import Sequence

import numpy as np

from fusion.geometry.pose import Array
from fusion.mesh.comparison.statistics import OVER, Knowable
from fusion.mesh.drawing.shading import Lit
from fusion.mesh.mesh import Mesh
from fusion.report.kit.page import Figure
from fusion.report.kit.palette import DIVERGING, SEQUENTIAL
from fusion.report.kit.views import Scale, ViewRow, mesh_views, nice_length, scale_colors

CAPTION = (
    "One standard deviation along the normal: noise and spread of the views, blur where the surface bends, poses, "
    "calibration. The true surface is expected within 1.645 times of it at 90 % of the surface. Grey: unknown."
)


def sigma_of(mesh: Mesh) -> Array | None:
    """(n,) [m], when the mesh carries it and some of it is known."""
    sigma = mesh.scalars.get("sigma")
    known = sigma is not None and len(sigma) == len(mesh.vertices) and bool(np.isfinite(sigma).any())
    return np.asarray(sigma, float) if known else None


def sigma_scale(sigma: Array) -> Scale:
    """Colours [mm] from 0 to what 98 % stay below, rounded up to 1, 2, 5 times a power of ten."""
    wanted = max(float(np.percentile(sigma[np.isfinite(sigma)], 98)) * 1000, 1e-3)
    low = nice_length(wanted)
    high = next(step * low for step in (1, 2, 2.5, 5) if step * low >= wanted * (1 - 1e-9))
    return Scale(SEQUENTIAL, 0.0, high, "standard deviation along the normal [mm]")


def sigma_figure(mesh: Mesh, sigma: Array, sights: Sequence[Lit]) -> Figure:
    """The mesh from several sides, coloured by sigma (n,) [m]."""
    middle, high = 1000 * np.percentile(sigma[np.isfinite(sigma)], [50, 95])
    title = f"Half of the surface is known to {middle:.2f} mm or better, 95 % to {high:.2f} mm"
    scale = sigma_scale(sigma)
    row = ViewRow(mesh, scale_colors(1000 * sigma, scale), sights=sights)
    return mesh_views([row], [sight.side for sight in sights], Figure(title, "sigma", title + ".", CAPTION), scale)


OVER_SCALE = Scale(DIVERGING, -6.0, 6.0, "deviation over sigma [1] (red: outside the reference, blue: inside)")


def over_sigma_figure(mesh: Mesh, known: Knowable, sights: Sequence[Lit]) -> Figure:
    """The mesh coloured by its deviation in standard deviations; pale within three of them."""
    title = f"{known.beyond_3_sigma:.1%} of the vertices deviate by more than three of the scan's standard deviations"
    caption = f"{known.within_90:.1%} are within 1.645 of them; 90 % would be where only the scan errs. Grey: unknown."
    row = ViewRow(mesh, scale_colors(np.asarray(mesh.scalars[OVER], float), OVER_SCALE), sights=sights)
    return mesh_views(
        [row], [sight.side for sight in sights], Figure(title, "oversigma", title + ".", caption), OVER_SCALE
    )
