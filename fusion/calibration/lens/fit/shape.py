"""What a board's file does not say: rows that lie not as far apart as columns, and a board that bows.

Both are the same in all pictures, and a camera that is fitted without them takes them into its focal length and lens
without a sign (3 mm over 27 cm: 5 % of the focal length). So they are fitted with the camera and the poses, weakly held
to an even, flat board; views that do not tell them from the lens leave the camera's standard deviations wide.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.special import chdtrc, chdtri

from fusion.calibration.lens.fit.solve import jacobian
from fusion.calibration.lens.views import BoardView
from fusion.geometry.pose import Array

ESTABLISHED = 2.0  # standard deviations from 0: the usual test whether a term earns its place
# share of the longer side, and standard deviations, beyond which a board is called uneven or bowed
WORTH, SURE = 0.003, 4.0


@dataclass(frozen=True)
class BoardShape:
    """How a board differs from a flat grid of squares.

    With u and v from the board's middle in halves of its longer side, rows are stretched by `terms[0]`, and a point
    lies `terms[1] u^2 + terms[2] u v + terms[3] v^2` half sides out of the plane.
    """

    centre: Array  # (2,) middle of the board [m]
    half: float  # of its longer side [m]
    aspect: tuple[float, float]  # half the board's sides over `half`
    terms: Array  # (4,)
    weight: Array  # (4,) of a usual board, in information per variance of a corner [px^2]
    covariance: Array  # (4, 4) of the terms

    @property
    def is_sure(self) -> bool:
        """True where the views are sure that the board is uneven or bowed."""
        return bool(self.warnings())

    @property
    def pitch(self) -> tuple[float, float]:
        """(ratio, std): distance of the rows over that of the columns."""
        return 1 + float(self.terms[0]), float(np.sqrt(self.covariance[0, 0]))

    @property
    def bow(self) -> tuple[float, float]:
        """(bow, std): how far the board lies off a plane [m], from the furthest on one side to that on the other."""
        u, v = (axis.ravel() for axis in np.meshgrid(*(np.linspace(-side, side, 9) for side in self.aspect)))
        out = _bows(u, v) * self.half
        z = out @ self.terms[1:]
        slope = out[np.argmax(z)] - out[np.argmin(z)]
        return float(np.ptp(z)), float(np.sqrt(slope @ self.covariance[1:, 1:] @ slope))

    def warnings(self) -> list[str]:
        """A sentence for each way in which the board is not what its file says, and the views are sure of it."""
        (ratio, sigma), (bow, off), side = self.pitch, self.bow, 2 * self.half
        found = []
        if abs(ratio - 1) > max(WORTH, SURE * sigma):
            wider, other = ("rows", "columns") if ratio > 1 else ("columns", "rows")
            found.append(f"the board's {wider} are further apart than its {other}, by {abs(ratio - 1):.2%} "
                         f"(+- {sigma:.2%}): measure the print along both sides; the camera was fitted with this, and "
                         f"with columns as far apart as stated")  # fmt: skip
        if bow > max(WORTH * side, SURE * off):
            found.append(f"the board bows by {1000 * bow:.1f} +- {1000 * off:.1f} mm over the {1000 * side:.0f} mm of "
                         f"its corners: glue it to something flat; the camera was fitted with this")  # fmt: skip
        return found

    def established(self) -> "BoardShape":
        """The shape as far as the views establish it: even or flat where they do not."""
        C, held = self.covariance, np.zeros(4, bool)
        for part in ([0], [1, 2, 3]):
            chi2 = self.terms[part] @ np.linalg.lstsq(C[np.ix_(part, part)], self.terms[part], rcond=None)[0]
            # what noise exceeds as rarely as one term that many standard deviations
            held[part] = not chi2 > chdtri(len(part), chdtrc(1, ESTABLISHED**2))
        # what the others are once those are known
        moved = C[:, held] @ np.linalg.lstsq(C[np.ix_(held, held)], self.terms[held], rcond=None)[0]
        return replace(self, terms=np.where(held, 0.0, self.terms - moved))

    def on(self, view: BoardView) -> BoardView:
        """A view of a flat grid as one of this board."""
        u, v = self._place(view.points)
        rows = self.centre[1] + v * self.half * (1 + self.terms[0])
        return replace(
            view, points=np.column_stack([view.points[:, 0], rows, self.half * _bows(u, v) @ self.terms[1:]])
        )

    def jacobian(self, view: BoardView, pose: Array, parameters: Array) -> tuple[Array, Array]:
        """As `solve.jacobian` of a view of this board, with columns for the terms between camera and pose."""
        J, r = jacobian(view, pose, parameters)
        by_point = J[:, -3:] @ cv2.Rodrigues(pose[:3])[0]  # a step of the point is one of the board, turned
        u, v = self._place(view.points)
        rows = by_point[:, 1] * np.repeat(v * self.half, 2)
        bows = by_point[:, 2:] * np.repeat(_bows(u, v) * self.half, 2, axis=0)
        return np.column_stack([J[:, :-6], rows, bows, J[:, -6:]]), r

    def _place(self, points: Array) -> tuple[Array, Array]:
        u, v = ((points[:, :2] - self.centre) / self.half).T
        return u, v


def _bows(u: Array, v: Array) -> Array:
    return np.column_stack([u * u, u * v, v * v])
