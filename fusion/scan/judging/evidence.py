"""What a turntable scan knows about its own faults, beside what it hands out."""

from dataclasses import dataclass

from fusion.geometry.camera import Camera
from fusion.results.light import Light
from fusion.scan.judging.agreement import Agreement
from fusion.scan.judging.print_agreement import PrintAgreement
from fusion.scan.judging.pulled import Pulled
from fusion.turntable.focal import FocalCheck
from fusion.turntable.jumps import Jump


@dataclass(frozen=True)
class Evidence:
    """What the judgement of a scan rests on."""

    stated_camera: Camera  # as the recording has it (after known errors of the lens were taken out)
    focal: FocalCheck  # what the turning object says of its focal length
    refined: bool  # the scan's own focal length was taken
    jump: Jump | None  # the largest sudden move of object or camera, None when there is none
    noise: float  # standard deviation of the depth on the object [m]
    kept_share: float  # share of the surface that hangs together; the rest was dropped
    agreement: Agreement  # of single frames with the model
    # of what is printed on the object, from view to view; None where no colours helped to find the motion
    print: PrintAgreement | None = None
    pulled: Pulled | None = None  # by how much the poses bend the surface; None where no views overlap
    hidden: float = 0.0  # so far above the plate the object cannot be told from it [m]
    # share of the surface behind which another lies within the truncation: each disturbs the other
    thin_share: float = 0.0
    notes: tuple[Light, ...] = ()  # of the recording's doctor, of readers and of the correction
    footnotes: tuple[str, ...] = ()  # sentences that come with nearly every scan of such a sensor
