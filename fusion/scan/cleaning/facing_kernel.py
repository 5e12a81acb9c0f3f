# mypy: ignore-errors
"""Where points of a surface lie in the images of some cameras, on Taichi."""

from fusion.compute.language import F32_2, F64, F64_2, F64_3, I32, I32_2, kernel, ti
from fusion.geometry.lanes import project

vec3 = ti.types.vector(3, ti.f64)
NEAREST = 0.05  # [m] before the camera: none measures nearer
DEPTH, COSINE, TANGENT = range(3)


@kernel
def place_points(
    points: F64_2,  # (n, 3) [m]
    normals: F32_2,  # (n, 3)
    poses: F64_3,  # (k, 4, 3) of each camera the turn into its frame, and where it is
    lens: F64,  # (12,) see `Camera.parameters`
    size: I32,  # (2,) height, width [px]
    least: ti.f64,  # cosine between normal and line of sight
    place: I32_2,  # (k, n) out: pixel by rows, -1 of a point that looks away or lies beside the image
    seen: F64_3,  # (k, n, 3) out: depth [m], cosine, tangent of the angle to the optical axis
):
    for k, n in ti.ndrange(poses.shape[0], points.shape[0]):
        place[k, n] = -1
        for s in ti.static(range(3)):
            seen[k, n, s] = 0.0
        away = vec3([points[n, s] - poses[k, 3, s] for s in ti.static(range(3))])
        towards = -(away[0] * normals[n, 0] + away[1] * normals[n, 1] + away[2] * normals[n, 2])
        if towards > least * away.norm():
            p = vec3(
                [
                    poses[k, s, 0] * away[0] + poses[k, s, 1] * away[1] + poses[k, s, 2] * away[2]
                    for s in ti.static(range(3))
                ]
            )
            if p[2] > NEAREST:
                a, b = p[0] / p[2], p[1] / p[2]
                x, y = project(a, b, lens, True)
                u, v = ti.floor(x + 0.5), ti.floor(y + 0.5)
                if 0 <= u < size[1] and 0 <= v < size[0]:
                    place[k, n] = ti.cast(v, ti.i32) * size[1] + ti.cast(u, ti.i32)
                    seen[k, n, DEPTH], seen[k, n, COSINE] = p[2], towards / away.norm()
                    seen[k, n, TANGENT] = ti.sqrt(a * a + b * b)
