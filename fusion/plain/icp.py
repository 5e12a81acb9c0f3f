# mypy: ignore-errors
"""What all pairs of points say about a pose: projective data association and point-to-plane equations.

Each source point, moved by the pose, is met by the model's point on the same line of sight. r = n . (moved - met) is
its equation (Chen and Medioni 1992; Newcombe et al. 2011, KinectFusion, equations 16 to 21), weighted by the spread
that its noise gives it and by Tukey's biweight. Summed up: J^T W J x = -J^T W r with J = [(moved - centre) x n, n].
"""

import numpy as np

from fusion.compute.language import F32, F32_2, F32_3, F64_2, kernel, ti
from fusion.compute.start import start
from fusion.geometry.robust import CUT, MAD_TO_STD
from fusion.plain.view import moved, numbers, pixel, turned
from fusion.tracking.equations import LATERAL, STEEP, Equations

# columns of a point's row: derivatives (6), residual [m], weight [1/m^2], residual in standard deviations, met, visible
JACOBIAN, RESIDUAL, WEIGHT, ODDS, MET, VISIBLE = 0, 6, 7, 8, 9, 10


def equations(source, T_model_source, model, limits):
    """The equations of all source points at a pose (4, 4), as `fusion.tracking.equations.equations`."""
    start()
    points = np.ascontiguousarray(np.moveaxis(source.lanes, 1, 2).reshape(-1, 7))
    rows = np.zeros((len(points), 11))
    centre = T_model_source[:3, :3] @ source.centre + T_model_source[:3, 3]
    how = numbers(T_model_source, model.camera.parameters, centre,
                  (limits.reach, limits.min_cosine, limits.scale, limits.open_to))  # fmt: skip
    images = (np.ascontiguousarray(image, np.float32) for image in (model.points, model.normals, model.sigma))
    if len(points) and min(model.camera.shape) > 1:
        pair(points, *images, how, rows)
    J, r, weight, met = rows[:, :RESIDUAL], rows[:, RESIDUAL], rows[:, WEIGHT], rows[:, MET] > 0
    kept = weight > 0
    scale = MAD_TO_STD * float(np.median(rows[met, ODDS])) if met.any() else 1.0
    information = np.einsum("n,ni,nj->ij", weight, J, J)
    return Equations(
        information, np.einsum("n,ni,n->i", weight, J, r), float(weight.sum()), float(np.sum(r[kept] ** 2)),
        int(kept.sum()), int(met.sum()), int(rows[:, VISIBLE].sum()), max(1.0, scale),
    )  # fmt: skip


@kernel
def pair(source: F32_2, points: F32_3, normals: F32_3, sigma: F32_2, how: F32, rows: F64_2):
    """The row of each source point, zeros where it meets nothing. `how`: pose (12), camera (12), centre (3), reach,
    least cosine, scale, open_to."""
    for i in range(source.shape[0]):
        q = moved(how, ti.Vector([source[i, 0], source[i, 1], source[i, 2]]))
        m = turned(how, ti.Vector([source[i, 3], source[i, 4], source[i, 5]]))
        bottom, right = points.shape[0] - 1, points.shape[1] - 1
        u, v = pixel(q, how, 12)
        if source[i, 6] >= 0 and q[2] > 0.05 and 0 <= u <= right and 0 <= v <= bottom:
            v0, u0 = ti.min(ti.floor(v, ti.i32), bottom - 1), ti.min(ti.floor(u, ti.i32), right - 1)
            a, b = u - u0, v - v0
            four = ti.Vector([points[v0 + k // 2, u0 + k % 2, 2] for k in range(4)])
            i4 = 1 / four  # on a plane, one over the depth is linear in the image
            z = 1 / ((1 - b) * ((1 - a) * i4[0] + a * i4[1]) + b * ((1 - a) * i4[2] + a * i4[3]))
            if z > 0 and four.max() - four.min() < STEEP / how[12] * z:
                rows[i, VISIBLE] = 1
                behind = 1 - z / q[2]  # the model's point is (1 - behind) q
                v1, u1 = v0 + ti.select(b < 0.5, 0, 1), u0 + ti.select(a < 0.5, 0, 1)
                n = ti.Vector([normals[v1, u1, k] for k in range(3)])
                if ti.abs(behind) * q.norm() < how[27] and m.dot(n) > how[28]:
                    rows[i, MET] = 1
                    r, cosine = n.dot(q) * behind, n.dot(q) / q.norm()
                    # noise acts along the line of sight; across it a pixel's depth may come from anywhere in the pixel
                    s = source[i, 6] ** 2 + ti.select(sigma[v1, u1] > 0, sigma[v1, u1], 0.0) ** 2
                    aslant = (1 - cosine**2) * (LATERAL * q[2] / how[12]) ** 2
                    spread = ti.sqrt(cosine**2 * s + aslant + 1e-10)
                    rows[i, ODDS] = ti.abs(r) / spread
                    spread *= how[29]
                    t = r / ti.max(CUT * spread, how[30])
                    rows[i, WEIGHT] = (ti.max(1 - t * t, 0.0) / spread) ** 2
                    rows[i, RESIDUAL] = r
                    turn = (q - ti.Vector([how[24], how[25], how[26]])).cross(n)
                    for k in ti.static(range(3)):
                        rows[i, k], rows[i, 3 + k] = turn[k], n[k]
