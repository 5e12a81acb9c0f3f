"""A camera from pictures of a board: corners, fit, outliers, and how well it is known."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from fusion.calibration.lens.boards.board import Board
from fusion.calibration.lens.boards.pictures import BoardPictures, find_pictures, thinned
from fusion.calibration.lens.boards.search import FEWEST, Search, search
from fusion.calibration.lens.fit.alike import unlike
from fusion.calibration.lens.fit.joint import board_shape, check_pitch
from fusion.calibration.lens.fit.outliers import JudgedViews, judge
from fusion.calibration.lens.fit.shape import ESTABLISHED, BoardShape
from fusion.calibration.lens.fit.size import size_warnings
from fusion.calibration.lens.fit.solve import NAMES, solve
from fusion.calibration.lens.fit.spread import LensSpread, spread
from fusion.calibration.lens.fit.terms import is_rational
from fusion.calibration.lens.fit.usual import unusual
from fusion.calibration.lens.pair import CameraPair, place_color
from fusion.calibration.lens.uncertainty import ProjectionUncertainty, projection_uncertainty
from fusion.calibration.lens.views import BoardView, covered, different
from fusion.errors import RecordingError
from fusion.geometry.camera import Camera
from fusion.progress import stage

K3 = NAMES.index("k3")
OPEN = 0.1  # relative standard deviation of the focal length beyond which there is no camera
POOR = 0.01  # beyond which meshes suffer (guess)
TILT = "record more views with the board tilted by 20 to 45 degrees in several directions"


@dataclass(frozen=True)
class LensSettings:
    """What a user may choose.

    Attributes:
        keep_outliers: name views that do not fit, but use them.
        distance: working distance [m]; None: the middle distance of the boards.
        most: pictures looked at, evenly over the recording.
    """

    keep_outliers: bool = False
    distance: float | None = None
    most: int = 200


@dataclass(frozen=True)
class CameraFit:
    """One camera, and all that is known about how good it is."""

    camera: Camera  # with `std` of every parameter
    judged: JudgedViews  # views used, outliers, solution
    spread: LensSpread  # covariance, jackknife, influence of every view
    uncertainty: ProjectionUncertainty  # of the projection over the picture
    coverage: float  # share of the picture in which corners were seen
    shape: BoardShape  # of the board as the views tell it: uneven, bowed
    k3_held: bool = False  # the views do not establish k3; it is 0

    @property
    def tilt(self) -> float:
        """95th percentile of the angle [deg] between board and picture: what tells the focal length."""
        normals = np.array([cv2.Rodrigues(pose[:3])[0][2, 2] for pose in self.judged.solution.poses])
        return float(np.percentile(np.degrees(np.arccos(np.abs(normals).clip(0, 1))), 95))

    @property
    def most_influential(self) -> tuple[str, float]:
        """The view without which the camera would change most, and by how many standard deviations at most."""
        with np.errstate(invalid="ignore"):
            sigmas = np.nanmax(np.abs(self.spread.shifts) / self.spread.std, axis=1)
        worst = int(np.nanargmax(sigmas))
        return self.judged.views[worst].name, float(sigmas[worst])


@dataclass(frozen=True)
class Intrinsics:
    """The result for a recording."""

    camera: Camera  # the IR (or only) camera, with the colour camera and its place where both were given
    board: Board  # that was looked for
    # searches, fits: of the cameras, "ir" first where there is one
    searches: dict[str, Search]
    fits: dict[str, CameraFit]
    pair: CameraPair | None = None  # how the colour camera stands, or None
    warnings: list[str] = field(default_factory=list)  # one sentence each

    def __repr__(self) -> str:
        views = ", ".join(f"{len(fit.judged.views)} views ({name})" for name, fit in self.fits.items())
        return f"<Intrinsics by {views}, {len(self.warnings)} warnings;\n {self.camera!r}>"


def calibrate_intrinsics(
    path: Path | str, board: Board, settings: LensSettings | None = None, topic: str | None = None
) -> Intrinsics:
    """Calibrate the camera or cameras of a recording of any format, or of a plain folder of pictures.

    Args:
        path: the recording or the folder.
        board: what the pictures show.
        settings: how.
        topic: which depth stream of a bag that has several.

    Raises:
        RecordingError: no pictures, too few views, another board, uneven squares, or views that leave the camera open.

    >>> found = fusion.calibrate_intrinsics("board", fusion.read_board("board/board.json"))
    >>> fusion.write_camera("camera.json", found.camera)
    """
    settings = settings or LensSettings()
    pictures = find_pictures(path, topic)
    searches, fits, warnings = {}, {}, []
    for name, files in (("ir", pictures.ir), ("color", pictures.color)):
        if not files:
            continue
        try:
            searches[name] = search(thinned(files, settings.most), board)
            with stage("fitting"):
                fits[name] = fit_camera(searches[name].views, searches[name].size, settings)
        except RecordingError as error:
            if name == "ir" or not fits:
                raise
            warnings.append(f"the colour camera was left out: {error}")
    pair = None
    if len(fits) == 2:
        try:
            ir, color = fits["ir"], fits["color"]
            pair = place_color(ir.judged.views, color.judged.views, ir.camera, color.camera)
        except RecordingError as error:
            warnings.append(f"the colour camera's place stays unknown: {error}")
    if "ir" in fits:
        warnings += size_warnings(pictures.path, fits["ir"].judged)
    for fit in fits.values():
        warnings += fit.shape.warnings() + unlike(fit.judged.views, fit.judged.solution, fit.spread.sigma_px)
        warnings += _unsure(fit)
        warnings += unusual(fit.judged.solution, fit.spread.covariance, fit.camera.shape[::-1])
    camera = _joined(pictures, fits, pair, warnings)
    return Intrinsics(camera, board, searches, fits, pair, warnings)


def fit_camera(views: Sequence[BoardView], size: tuple[int, int], settings: LensSettings | None = None) -> CameraFit:
    """One camera from views of a board; size is (width, height) [px].

    Where views left out say that the lens is wider than three radial terms follow, all eight of OpenCV's are fitted.
    A k3 that the views do not establish is held at 0: left free it bends the corners of the picture, where no board was
    seen (measured on a challenge with known truth: 1.2 px rms over the picture with a free k3, 0.2 px with it held).
    In the same way a board that the views do not establish as uneven or bowed is held even and flat. The standard
    deviations and the projection's uncertainty stay those with k3 and the board's shape free.

    Raises:
        RecordingError: too few views, contradicting ones, uneven squares, or a parameter that stays open.
    """
    settings = settings or LensSettings()
    _check_different(views)
    judged, shape = _with_shape(views, views, size, settings)
    if shape.is_sure:  # a view is no outlier for what the board is in all of them
        judged, shape = _with_shape(views, [shape.on(view) for view in views], size, settings)
    rational = len(judged.solution.names) > len(NAMES)
    known = spread([shape.on(view) for view in judged.views], judged.solution, shape)
    check_pitch(*shape.pitch)
    _check_open(judged, known)
    std = {name: float(value) for name, value in zip(judged.solution.names, known.std, strict=True)}
    free = judged.solution.camera(size)
    distance = settings.distance or float(np.median(np.linalg.norm(judged.solution.poses[:, 3:], axis=1)))
    uncertainty = projection_uncertainty(free, known.covariance, distance)
    held = not rational and bool(abs(judged.solution.parameters[K3]) < ESTABLISHED * known.scatter[K3])
    start = np.concatenate([judged.solution.parameters[:K3], [0.0]]) if held else judged.solution.parameters
    used = [shape.established().on(view) for view in judged.views]
    judged = replace(judged, views=used, solution=solve(used, size, start, hold_k3=held))
    camera = replace(judged.solution.camera(size), std=std)
    return CameraFit(camera, judged, known, uncertainty, covered(judged.views, size), shape, held)


def _with_shape(
    flat: Sequence[BoardView], views: Sequence[BoardView], size: tuple[int, int], settings: LensSettings
) -> tuple[JudgedViews, BoardShape]:
    """The flat views that fit, judged by the shape that `views` have; camera and shape fitted to them together."""
    judged = judge(views, size, settings.keep_outliers, is_rational(views, size))
    named = {view.name: view for view in flat}
    kept = [named[view.name].only(np.isin(named[view.name].ids, view.ids)) for view in judged.views]
    shape, solution = board_shape(kept, judged.solution)
    return replace(judged, views=kept, solution=solution), shape


def _check_different(views: Sequence[BoardView]) -> None:
    """Refuse many pictures of a board that stood still. Raises RecordingError."""
    count = len(different(views))
    if len(views) >= FEWEST > count:
        found = f"{len(views)} pictures of {'a single view' if count == 1 else f'{count} views'}"
        expected = f"{FEWEST} views or more, better 20"
        raise RecordingError("too few different views of the board", found=found, expected=expected, do=TILT)


def _check_open(judged: JudgedViews, known: LensSpread) -> None:
    """Refuse a camera whose focal length the views do not tell. Raises RecordingError."""
    share = float(np.max(known.std[:2] / np.abs(judged.solution.parameters[:2])))
    if not share < OPEN:
        found = f"a standard deviation of {share:.0%} from {len(judged.views)} views"
        raise RecordingError(
            "the views leave the focal length open", found=found, expected=f"below {OPEN:.0%}", do=TILT
        )


def _unsure(fit: CameraFit) -> list[str]:
    """A sentence where the focal length is hardly known, and what would tell it."""
    share = max(fit.camera.std["fx"] / fit.camera.fx, fit.camera.std["fy"] / fit.camera.fy)
    if share <= POOR:
        return []
    return [
        f"the focal length is known to {share:.1%} only; the boards are tilted by up to {fit.tilt:.0f} degrees: {TILT}"
    ]


def _joined(
    pictures: BoardPictures, fits: dict[str, CameraFit], pair: CameraPair | None, warnings: list[str]
) -> Camera:
    """The camera with what `camera.json` already said about the sensor, and the colour camera inside."""
    main, *_ = fits.values()
    camera, before = main.camera, pictures.camera
    if before is not None:
        camera = replace(camera, depth_scale=before.depth_scale, principle=before.principle, sensor=before.sensor,
                         serial=before.serial)  # fmt: skip
        if before.shape != camera.shape:
            warnings.append(
                f"the pictures are {camera.width} x {camera.height} px, camera.json says "
                f"{before.width} x {before.height}: the new camera is that of the pictures"
            )
    if pair is not None:
        camera = replace(camera, color=fits["color"].camera, T_color_depth=pair.T_color_depth)
    elif len(fits) == 1 and "color" in fits:
        warnings.append("only colour pictures were found: this is the colour camera's geometry")
    return camera
