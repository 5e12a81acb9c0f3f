"""What colour images show in the pixels of the depth camera, frame by frame, for tracking."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.coloring.images import ColorImage, ColorImages, color_images
from fusion.errors import RecordingError
from fusion.geometry.pose import transform
from fusion.recording.recording import Frame, Recording


@dataclass(frozen=True)
class Colors:
    """The colour images of a recording."""

    source: ColorImages  # where they are

    @staticmethod
    def of(recording: Recording) -> "Colors | None":
        """None where the recording names no colour image."""
        source = color_images(recording)
        return None if source is None else Colors(source)

    def seen_at(self, index: int, frame: Frame, window: tuple[slice, slice]) -> NDArray[np.uint8] | None:
        """(h, w, 3) in a window of the depth camera's pixels, black where unknown; None without an image."""
        source = self.source
        if not source.apart:
            shape = source.recording.camera.shape
            fits = frame.color is not None and frame.color.shape[:2] == shape
            return np.ascontiguousarray(frame.color[window]) if fits and frame.color is not None else None
        try:
            image = source.recording.color_apart(index)
        except RecordingError:  # told where the mesh is coloured
            return None
        if image is None or image.shape[:2] != source.camera.shape:
            return None
        points = source.recording.camera.points(frame.depth)[window]
        known = np.isfinite(points[..., 2])
        seen = transform(source.T_color_depth, points[known].astype(float))
        pixels = source.camera.project(np.where(seen[:, 2:] > 1e-3, seen, [[0.0, 0.0, 1.0]]))
        out = np.zeros((*known.shape, 3), np.uint8)
        out[known] = ColorImage(image, frame.depth).sampled(pixels).astype(np.uint8)
        return out
