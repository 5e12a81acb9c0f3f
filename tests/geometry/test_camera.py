"""A camera's two directions are each other's inverse, with every kind of lens."""

import numpy as np
import pytest

from fusion.geometry.camera import Camera

CAMERAS = {
    "pinhole": Camera(64, 48, 57.0, 58.0, 31.5, 23.5),
    "off centre": Camera(61, 47, 80.0, 70.0, 12.3, 40.9),
    "kinect v1": Camera(640, 480, 591.0, 590.0, 331.0, 235.0, (-0.26, 0.87, -0.002, 0.001, -0.98)),
    "kinect v2": Camera(512, 424, 365.0, 365.0, 255.0, 206.0, (0.093, -0.27, 0.0, 0.0, 0.096)),
    "rational": Camera(640, 576, 504.0, 504.0, 320.0, 335.0, (1.20, 0.41, 1e-4, -5e-5, 0.012, 1.54, 0.68, 0.071)),
}


@pytest.fixture(params=CAMERAS, ids=str)
def camera(request) -> Camera:
    return CAMERAS[request.param]


def depth_of(camera: Camera) -> np.ndarray:
    """A surface that is nowhere flat, 0.5 to 2 m."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    return (1.25 + 0.75 * np.sin(0.13 * u) * np.cos(0.09 * v)).astype(np.float32)


def test_projected_points_return_to_their_pixel(camera):
    points = camera.points(depth_of(camera))
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    # rays are float32 (1e-7 of a few hundred pixels); a pixel of 1e-3 moves a point at 1 m by 2 micrometres
    np.testing.assert_allclose(camera.project(points), np.dstack([u, v]).reshape(-1, 2), atol=1e-3)


def test_depth_is_planar_z(camera):
    depth = depth_of(camera)
    np.testing.assert_array_equal(camera.points(depth)[..., 2], depth)


def test_points_scale_with_depth(camera):
    depth = depth_of(camera)
    np.testing.assert_allclose(camera.points(2 * depth), 2 * camera.points(depth), rtol=1e-6)  # float32


def test_missing_depth_stays_missing(camera):
    depth = depth_of(camera)
    depth[::3, ::2] = np.nan
    points = camera.points(depth)
    np.testing.assert_array_equal(np.isnan(points).all(axis=-1), np.isnan(depth))
    np.testing.assert_array_equal(np.isnan(points).any(axis=-1), np.isnan(depth))


def test_the_halved_camera_sees_the_same_point(camera):
    """The centre of a 2 x 2 block lies at (u - 0.5) / 2: pixel (0, 0) is the centre of the top-left pixel."""
    half = camera.halved()
    points = camera.points(depth_of(camera)).reshape(-1, 3)
    # cv2 works in double; only the halving's arithmetic is between the two
    np.testing.assert_allclose(half.project(points), (camera.project(points) - 0.5) / 2, atol=1e-9)
    assert half.shape == (camera.height // 2, camera.width // 2)


def test_the_centre_of_the_top_left_pixel_is_zero():
    camera = Camera(3, 3, 1.0, 1.0, 0.0, 0.0)
    np.testing.assert_array_equal(camera.rays()[0, 0], [0, 0])
    np.testing.assert_array_equal(camera.rays()[2, 1], [1, 2])  # [v, u] gives x, y


def test_short_distortion_is_filled_with_zeros():
    short, full = Camera(4, 4, 1, 1, 0, 0, (0.1, 0.2)), Camera(4, 4, 1, 1, 0, 0, (0.1, 0.2, 0, 0, 0, 0, 0, 0))
    assert short == full
    assert hash(short) == hash(full)
    np.testing.assert_allclose(short.parameters, [1, 1, 0, 0, 0.1, 0.2, 0, 0, 0, 0, 0, 0], rtol=1e-7)


def test_rays_are_shared_and_cannot_be_written(camera):
    assert camera.rays() is camera.rays()
    with pytest.raises(ValueError, match="read-only"):
        camera.rays()[0, 0] = 0


def test_no_points_give_no_pixels(camera):
    assert camera.project(np.zeros((0, 3))).shape == (0, 2)


def test_a_resized_image_keeps_its_borders():
    camera = Camera(64, 48, 60.0, 61.0, 30.3, 25.8)
    for width, height in ((32, 12), (96, 120)):
        other = camera.resized(width, height)
        for own, same in (((-0.5, -0.5), (-0.5, -0.5)), ((63.5, 47.5), (width - 0.5, height - 0.5))):
            rays = [((u - c.cx) / c.fx, (v - c.cy) / c.fy) for c, (u, v) in ((camera, own), (other, same))]
            np.testing.assert_allclose(rays[0], rays[1], atol=1e-12)
