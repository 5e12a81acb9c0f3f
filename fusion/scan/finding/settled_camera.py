"""The focal length that a scan itself settles."""

from dataclasses import replace

from fusion.errors import TrackingError
from fusion.geometry.camera import Camera
from fusion.geometry.robust import SURE
from fusion.scan.finding.attempt import Attempt, seen_by
from fusion.scan.settings import ScanSettings
from fusion.turntable.all_views.camera_fit import WORTH
from fusion.turntable.focal import FocalCheck, focal_of

ROUNDS = 2  # corrections of the focal length: each starts from a nominal one, pairs points anew and is nearer


def settle_camera(first: Attempt) -> tuple[Attempt, FocalCheck]:
    """The attempt with the camera that is used, and what the scan says of the stated focal length.

    A scan that contradicts its camera is tried with the focal length that it asks for. Where it fits no better so,
    something else is wrong, and the claim is withdrawn. Where it does, and the camera is only nominal or it is asked
    for, that focal length is taken, and made better once more.
    """
    camera, settings = first.camera, first.asked.settings
    claim = focal_of(first.fit.motion, camera)
    forced = settings.refine_camera is True
    if not forced and claim.deviations(camera) <= SURE:
        return first, claim
    second = _with_focal_length_of(first)
    if not forced and (second is None or second.misfit > WORTH * first.misfit):
        return first, claim.withdrawn()
    if second is None or not (forced or refines(settings, camera)):
        return first, claim
    for _ in range(ROUNDS - 1):
        left = focal_of(second.fit.motion, second.camera)
        third = _with_focal_length_of(second) if abs(left.relative) > left.std else None
        if third is None or third.misfit > second.misfit / WORTH:
            break
        second = third
    taken = second.camera.fx / camera.fx - 1
    return second, replace(focal_of(second.fit.motion, second.camera), relative=taken)


def refines(settings: ScanSettings, camera: Camera) -> bool:
    """Whether a focal length that the scan contradicts may be replaced: as asked, else where it is only nominal."""
    return "fx" not in camera.std if settings.refine_camera is None else settings.refine_camera


def _with_focal_length_of(found: Attempt) -> Attempt | None:
    """The same with the focal length that this attempt asks for; None where nothing turns then.

    The principal point is free in that fit, or its error would pull the focal length along; but it is not taken over:
    depth errors imitate it, and what it is wrong by turns the whole scan, nearly, and bends nothing. Measured on the
    statue of the open challenges, nominal camera: distance std 0.60 mm with the focal length alone, 1.47 mm with both.
    """
    try:
        return seen_by(found.fit.motion.focal_check.only("focal").camera(found.camera), found)
    except TrackingError:
        return None
