"""What a volume works with from frame to frame, besides the voxels: its own, as two volumes may be used at once."""

from threading import RLock

from fusion.compute.spare import Spare
from fusion.volume.integration.frame import work
from fusion.volume.raycasting.image_pool import ImagePool


class Scratch:
    """A volume's scratch images, and whose turn it is.

    Attributes:
        turn: held by the thread that works on the volume; others wait.
        frames: images that frames are worked on in, by camera.
        canvases: images that raycasts are written to.
    """

    def __init__(self) -> None:
        self.turn = RLock()
        self.frames = Spare(work, most=2)  # a depth camera, and one of another size
        self.pool = ImagePool()

    def __reduce__(self) -> tuple[type, tuple[()]]:
        """A copy of a volume has scratch of its own."""
        return Scratch, ()
