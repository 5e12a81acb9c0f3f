"""Does the camera fit its images?"""

import math

from fusion.recording.looking.finding import Finding
from fusion.recording.looking.sample import Sample

# share of the side that a principal point may lie off the middle: real ones stay below 0.06, crops do not
OFF_CENTRE = 0.15
# [deg] horizontal field of view of depth cameras: 33 (YCB-Video's Xtion) to 120 (Azure Kinect, wide)
FIELD_OF_VIEW = (15.0, 140.0)


def check_intrinsics(sample: Sample) -> list[Finding]:
    """Principal point far off the middle, a field of view no camera has, pixels far from square."""
    camera = sample.recording.camera
    findings = []
    for name, value, side in (("cx", camera.cx, camera.width), ("cy", camera.cy, camera.height)):
        off = (value - (side - 1) / 2) / side
        if abs(off) > OFF_CENTRE:
            severity = "error" if abs(off) > 0.4 else "warning"
            seen = f"{name} = {value:.1f} in an image of {camera.width} x {camera.height}"
            do = (
                f"pass --camera with the intrinsics of this size; these look like those of about {2 * value + 1:.0f} px"
            )
            findings.append(Finding("intrinsics", severity, seen, do))
    degrees = math.degrees(2 * math.atan(camera.width / 2 / camera.fx))
    if not FIELD_OF_VIEW[0] <= degrees <= FIELD_OF_VIEW[1]:
        seen = f"fx = {camera.fx:.1f} px gives a field of view of {degrees:.0f} deg over {camera.width} px"
        findings.append(Finding("intrinsics", "warning", seen, "pass --camera with the intrinsics of this size"))
    if not 0.8 < camera.fx / camera.fy < 1.25:
        seen = f"fx = {camera.fx:.1f} and fy = {camera.fy:.1f} px: pixels far from square"
        findings.append(Finding("intrinsics", "warning", seen, "pass --camera with the right focal lengths"))
    if not findings:
        seen = (
            f"centre, pixels and a field of view of {degrees:.0f} deg are usual; turntable scans judge the focal length"
        )
        findings.append(Finding("intrinsics", "ok", seen))
    return findings
