"""Has an image enough pixels to track a surface by its shape?"""

from dataclasses import replace

from fusion.recording.looking.finding import SEVERITIES, Finding
from fusion.recording.looking.sample import Sample

# an object that fills a fifth of the image must show some 150 points away from its rim, by which a turn is found; three
# of four pixels of so small an object are rim
PIXELS = 3000


def check_resolution(sample: Sample) -> list[Finding]:
    """Sensors of 8 x 8 to about 60 x 45 pixels: they can be looked at and evaluated, but carry no scan."""
    camera = sample.recording.camera
    count = camera.width * camera.height
    size = f"{camera.width} x {camera.height} pixels"
    if count >= PIXELS:
        return [Finding("resolution", "ok", f"{size} can carry a scan")]
    seen = f"{size} are too few to find how a thing turns or a camera moves by the shape that it sees"
    do = f"scan with a sensor of {PIXELS} pixels or more (64 x 48); this one serves fusion evaluate and simulate"
    return [Finding("resolution", "error", seen, do)]


def note_resolution(sample: Sample) -> list[Finding]:
    """The same where no scan is asked for: such a recording is good for other things."""
    found = check_resolution(sample)
    return [replace(f, severity=min(f.severity, "warning", key=SEVERITIES.index)) for f in found]
