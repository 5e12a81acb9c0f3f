# mypy: ignore-errors
"""Where the rays of all frames meet the model, and what each says there, in one Taichi kernel."""

from fusion.compute.language import F32, F32_2, I32, kernel, ti
from fusion.turntable.pairs.edge_pairs import ERRORS, depth_terms
from fusion.volume.hashing import lookup
from fusion.volume.sample import SampledField, blend, corners, slope

vec3 = ti.types.vector(3, ti.f32)
# columns of a ray's equation: residual [m], derivative in the angle, sigma [m], spoilt, height [m], and derivatives in
# what all frames share: the axis (4), then errors of depth where they are asked for
RESIDUAL, ANGLE, SIGMA, SPOILT, HEIGHT, SHARED = range(6)
AXIS = 4
CELLS = 64  # of one offset each in a block: two voxels along their edges
CLOSE = 0.02  # voxels from the surface at which a ray has met it
LEAST_COSINE = 0.2  # of ray and model normal
ALIKE = 0.7  # least cosine between the normals of pixel and model
# cosine to the axis, and height [m], of what may be the plate; absolute: so far an uncalibrated camera may bend it
PLATE_LEVEL, PLATE_NEAR = 0.9, 0.03


@kernel
def meet(
    frame: I32,  # (m,)
    rays: F32_2,  # (m, 8) as in `Rays`
    poses: F32_2,  # (n, 14) rows of T_object_camera, turn taken back; cosine and sine of the turn; NaN takes no part
    model: SampledField,
    reach: ti.f32,  # largest distance from the model [m]
    span: F32,  # (4,) of the errors of depth, see `pair_edges`
    cell: I32,  # (m,) out: place on the model, -1 for a ray that says nothing
    out: F32_2,  # (m, 9 or more) out: the equation
):
    """Follows each ray to the model."""
    for i in range(frame.shape[0]):
        cell[i] = -1
        T = ti.Matrix([[poses[frame[i], 4 * r + c] for c in ti.static(range(3))] for r in ti.static(range(3))])
        origin = vec3(poses[frame[i], 3], poses[frame[i], 7], poses[frame[i], 11])
        p = vec3(rays[i, 0], rays[i, 1], rays[i, 2])
        measured = T @ p + origin
        d = T @ (p / p.norm())
        x, distance, gradient, block, at = measured, 0.0, vec3(0.0), -1, ti.Vector([0, 0, 0])
        known = ti.abs(measured / model.voxel).max() < 1e6  # of NaN no comparison is true
        for step in range(3):
            if known and (step == 0 or ti.abs(distance) > CLOSE * model.voxel):
                if step > 0:
                    along = gradient.dot(d)
                    known = along < -0.5 * LEAST_COSINE
                    x += ti.math.clamp(-distance / along, -3.0 * reach, 3.0 * reach) * d
                base = ti.cast(ti.floor(x / model.voxel), ti.i32)
                block, at = lookup(base[0] >> 3, base[1] >> 3, base[2] >> 3, model.keys, model.ids), base & 7
                known = known and block >= 0
                if known:
                    f, lowest = corners(block, at[0], at[1], at[2], model.neighbours, model.voxels)
                    known = lowest > 0.0
                    a = x / model.voxel - base
                    distance, gradient = blend(f, a), slope(f, a) / model.voxel
        size = gradient.norm()
        if known and size > 0.5:
            n = gradient / size
            residual = (measured - x).dot(n) + distance
            cosine = -d.dot(n)
            # of no normal no comparison is true: what is beside a rim has none
            alike = not (T @ vec3(rays[i, 3], rays[i, 4], rays[i, 5])).dot(n) < ALIKE
            plate = ti.abs(n[2]) > PLATE_LEVEL and x[2] < PLATE_NEAR
            if ti.abs(residual) < reach and cosine > LEAST_COSINE and alike and not plate:
                cell[i] = block * CELLS + (at[0] >> 1) * 16 + (at[1] >> 1) * 4 + (at[2] >> 1)
                c, s = poses[frame[i], 12], poses[frame[i], 13]
                # place and normal on the table, before its turn is undone
                y = vec3(c * x[0] - s * x[1], s * x[0] + c * x[1], x[2])
                m = vec3(c * n[0] - s * n[1], s * n[0] + c * n[1], n[2])
                arm = y.cross(m)
                sigma = ti.max(rays[i, 6] * cosine, 1e-5)
                turning = n[0] * x[1] - n[1] * x[0]
                row = (residual, turning, sigma, rays[i, 7], x[2], arm[0], arm[1], m[0], m[1])
                for k in ti.static(range(SHARED + AXIS)):
                    out[i, k] = row[k]
                if out.shape[1] > SHARED + AXIS:
                    # where the ray meets the model: the pixel's own noise is in no factor of a product
                    terms = depth_terms(p * ((x - origin).norm() / p.norm()), span)
                    per_depth = d.dot(n) * p.norm() / p[2]
                    for k in ti.static(range(ERRORS)):
                        out[i, SHARED + AXIS + k] = per_depth * terms[k]


@kernel
def by_cell(cell: I32, place: I32, order: I32):
    """Numbers of the rays sorted by cell, in their own order within; place holds where each cell's begin."""
    ti.loop_config(serialize=True)
    for i in range(cell.shape[0]):
        if cell[i] >= 0:
            at = place[cell[i]]
            order[at] = i
            place[cell[i]] = at + 1
