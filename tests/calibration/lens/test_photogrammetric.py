"""Photogrammetric parameters go to OpenCV's form and back; Pagliari's table 1 is the example."""

import numpy as np
import pytest

from fusion.errors import FusionError
from fusion.geometry.camera import Camera
from tools.reproduce.calibration.photogrammetric import PhotogrammetricCamera, to_opencv, to_photogrammetric

RGB = PhotogrammetricCamera(
    640, 480, (3.58, 2.87), 3.099, (-0.040, -0.020), (-1.366e-3, 7.857e-4, 0.0), (-1.518e-4, -9.514e-4)
)
IR = PhotogrammetricCamera(
    640, 480, (6.66, 5.32), 6.497, (-0.005, -0.004), (1.795e-3, -8.337e-5, 0.0), (-1.835e-4, 2.538e-4)
)
PLAIN = PhotogrammetricCamera(320, 240, (4.8, 3.6), 4.0)


def values(camera: PhotogrammetricCamera) -> np.ndarray:
    return np.array([*camera.format_mm, camera.focal_mm, *camera.principal_mm, *camera.K, *camera.P])


@pytest.mark.parametrize("camera", [RGB, IR, PLAIN], ids=["rgb", "ir", "plain"])
def test_there_and_back_to_a_millionth(camera):
    there, _ = to_opencv(camera)
    back, _ = to_photogrammetric(there, camera.format_mm)
    # K3 is 0 and must stay so: 1e-12 mm^-6 moves a corner by a millionth of a pixel
    np.testing.assert_allclose(values(back), values(camera), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("camera", [RGB, IR, PLAIN], ids=["rgb", "ir", "plain"])
def test_forward_and_correction_are_each_others_inverse(camera):
    v, u = np.mgrid[0 : camera.height : 8, 0 : camera.width : 8]
    pixels = np.stack([u.ravel(), v.ravel()], axis=1).astype(float)
    # a hundredth of a pixel is asked for; the iteration stops at a millionth
    np.testing.assert_allclose(camera.pixels(camera.tangents(pixels)), pixels, atol=1e-5)


@pytest.mark.parametrize(("camera", "rms", "worst"), [(RGB, 0.02, 0.17), (IR, 0.01, 0.12), (PLAIN, 1e-9, 1e-9)])
def test_opencv_moves_pixels_to_nearly_the_same_place(camera, rms, worst):
    """The limits are what OpenCV's five terms leave at best (least squares: 0.0213 px rms and 0.0087 px rms)."""
    there, gap = to_opencv(camera)
    v, u = np.mgrid[0 : camera.height : 8, 0 : camera.width : 8]
    pixels = np.stack([u.ravel(), v.ravel()], axis=1).astype(float)
    rays = np.hstack([camera.tangents(pixels), np.ones((len(pixels), 1))])
    off = np.linalg.norm(there.project(rays) - pixels, axis=1)
    assert np.sqrt((off**2).mean()) <= rms
    assert off.max() <= worst
    assert gap <= worst


def test_pixels_need_not_be_square():
    there, _ = to_opencv(IR)
    assert there.fx == pytest.approx(6.497 / 6.66 * 640)  # 624 px
    assert there.fy == pytest.approx(6.497 / 5.32 * 480)  # 586 px
    # the principal point is measured from the middle of the sensor, y up; pixel (0, 0) is a centre
    assert there.cx == pytest.approx(319.5 - 0.005 / 6.66 * 640)
    assert there.cy == pytest.approx(239.5 + 0.004 / 5.32 * 480)


def test_from_opencv_and_back():
    camera = Camera(512, 424, 366.0, 365.0, 258.0, 207.0, (0.09, -0.27, 0.001, -0.002, 0.09))
    there, gap = to_photogrammetric(camera, (5.12, 4.24))
    back, _ = to_opencv(there)
    assert gap < 3  # px, in the outermost corner: a lens as strong as this is at the limit of both models
    assert there.pitch_mm[1] / there.pitch_mm[0] == pytest.approx(366.0 / 365.0)
    np.testing.assert_allclose(back.distortion[:5], camera.distortion[:5], rtol=1e-6)
    assert (back.fx, back.fy, back.cx, back.cy) == pytest.approx((366.0, 365.0, 258.0, 207.0))


def test_a_lens_that_cannot_be_written_is_refused():
    with pytest.raises(FusionError, match="other form"):
        to_opencv(PhotogrammetricCamera(640, 480, (6.66, 5.32), 6.497, K=(0.08, 0.02, 0.0)))
