"""What a reader of an evaluation should know, in sentences."""

from collections.abc import Sequence

import numpy as np

from fusion.calibration.shared_noise import FEWEST, LEAST_M
from fusion.evaluation.bump import bump_of
from fusion.evaluation.stretch_look import StretchLook
from fusion.geometry.robust import robust_std
from fusion.recording.checks.depth_values import implausible
from fusion.recording.checks.stamps import unit_of_stamps
from fusion.recording.looking.moved import wandered
from fusion.recording.readable import moving_notes, unread_text
from fusion.recording.recording import Recording

FEW = 20  # frames below which a standard deviation of a pixel is worth little
JUMP = 5.0  # robust standard deviations that make a frame stand out
FAR_OFF = 0.15  # share of the distance: what is that far from the stated one is another surface, or another unit
ASIDE = 0.3  # of the depth, from the axis that a camera turns about to a usual pixel
SHARE = 0.5  # of the noise: what motion brings of it is told (guess)
STILL_M, STILL_RAD = 1e-4, np.radians(0.01)  # the last digits that are told: what is less, or not stated, is no motion
MOVED = 0.02  # share of pixels and frames that move
Note = tuple[str, str]  # "ok", "warning" or "bad", and a sentence


def notes_on(looks: Sequence[StretchLook], recordings: Sequence[Recording]) -> list[Note]:
    """Remarks on frames, movement, light and truth, the grave ones first."""
    notes = _joined([(look.name, level, text) for look in looks for level, text in _on_look(look)])
    if not any(look.bias is not None and look.bias.truth for look in looks):
        text = "No distance is known: the offset cannot be told, only what bends. Log distance_m in telemetry.csv."
        notes.append(("warning", text))
    if all(look.still.ir is None and look.still.color is None for look in looks):
        notes.append(
            (
                "ok",
                "Neither IR nor colour was recorded in the depth camera's pixels: shares are not told over brightness.",
            )
        )
    for recording in recordings:
        wrong = unit_of_stamps(recording.timestamps)
        notes += [("bad", f"{recording.path.name}: {one.seen}: {one.do}.") for one in wrong]
    used = sum(look.still.frames + len(look.still.failures) for look in looks)
    notes += [(level, f"{text}.") for level, text in moving_notes(recordings, used)]
    notes += [("warning", f"{recording.path.name}: {text}.") for recording in recordings for text in recording.warnings]
    order = {"bad": 0, "warning": 1, "ok": 2}
    return sorted(dict.fromkeys(notes), key=lambda note: order[note[0]])


def _joined(told: list[tuple[str, str, str]]) -> list[Note]:
    """Notes with the names in front; what holds for several views is said once."""
    names: dict[Note, list[str]] = {}
    for name, level, text in told:
        names.setdefault((level, text), []).append(name)
    return [
        (level, f"{where[0] if len(where) == 1 else f'{len(where)} views, {where[0]} first'}: {text}")
        for (level, text), where in names.items()
    ]


def _on_look(look: StretchLook) -> list[Note]:
    still, notes = look.still, list[Note]()
    if still.frames == 1:
        notes.append(("warning", "one frame only, so nothing is said about noise and drift."))
    elif still.frames < FEW:
        notes.append(("warning", f"{still.frames} frames only; 100 are usual."))
    if still.failures:
        notes.append(("warning", f"{unread_text(still.failures)}."))
    if len(still.disturbed):
        notes.append(("warning", _movement(look)))
    known = still.depth.std[np.isfinite(still.depth.std)]
    if still.frames > 1 and known.size and not known.any():
        text = f"all {still.frames} frames hold the same depth: copies of one, or a scene without noise"
        notes.append(("bad", f"{text}; nothing is told about noise."))
    notes += _wandering(look)
    notes += _shared_noise(look)
    if look.coarse:
        text = f"depths lie {look.gap * 1e3:.1f} mm apart, further than the noise: a pixel shows one or two of them"
        notes.append(("warning", f"{text}, and its own noise depends on its place between them."))
    if look.bias is not None and look.bias.beside:
        text = f"{look.bias.stands()}: it is another thing, of which neither offset nor shared noise nor drift is told"
        notes.append(("warning", f"{text}; turn the camera until its middle sees the surface."))
    elif look.bias is not None and look.bias.truth and look.bias.proud:
        notes.append(("warning", f"{look.bias.stands()}: the offset is the middle's."))
    with_depth = still.depth.mean[np.isfinite(still.depth.mean)]
    if with_depth.size and (text := implausible(float(np.median(with_depth)))):
        notes.append(("bad", f"{text}."))
    offset, distance = (np.nan, np.nan) if look.bias is None else (look.bias.offset, look.bias.distance)
    if abs(offset) > FAR_OFF * distance:
        seen = f"{distance + offset:.3g} m are measured where {distance:.3g} m are stated"
        notes.append(("bad", f"{seen}: check distance_m, the depth unit and what fills the view."))
    if look.surface.kind == "distance" and not look.valid > 0:
        notes.append(("warning", f"no depth at the stated {look.surface.stated:.2f} m."))
    return notes


def _wandering(look: StretchLook) -> list[Note]:
    """A camera that its own poses say was carried on: each pixel then scatters by what passes before it."""
    depth, std = (image[np.isfinite(image)] for image in (look.still.depth.mean, look.still.depth.std))
    if not depth.size or not std.size:
        return []
    away, turned = wandered(look.stretch.recording, slice(*look.stretch.frames))
    if away < STILL_M and turned < STILL_RAD:  # noise may be 0: steps of depth hide it
        return []
    # an even motion of length 1 is 2/3 from the first third to the last, and spreads by 1 / sqrt(12)
    spread = 1.5 / np.sqrt(12) * (away + turned * ASIDE * float(np.median(depth)))
    if spread < SHARE * float(np.median(std)):
        return []
    text = f"by its stated poses the camera went on by {away * 1e3:.1f} mm and {np.degrees(turned):.2f} deg"
    return [("bad", f"{text}: noise and drift are of its motion too; record a still scene.")]


def _shared_noise(look: StretchLook) -> list[Note]:
    """Whole frames that jump, and noise that averaging over pixels does not remove."""
    centre, notes = look.still.centre, list[Note]()
    known = np.flatnonzero(np.isfinite(centre))
    if len(known) < FEWEST:
        return notes
    # what passes through the centre is told by itself; its pixels leave it out, and their mean cannot
    moves = 2 * len(look.still.disturbed) > look.still.frames
    bump = None if moves else bump_of(centre)
    if bump is not None:
        text = f"the whole centre shifts by {bump.by * 1e3:+.1f} mm at frame {bump.frame} and stays there"
        text += ": camera or scene was moved; offset and noise are of both"
        return [("bad", f"{text}. Give the frames before or after it alone.")]
    spread = robust_std(centre[known] - np.median(centre[known]))
    off = np.abs(centre - np.nanmedian(centre))
    jumps = known[off[known] > max(JUMP * spread, LEAST_M)]
    if len(jumps) and not moves:
        most = f"the most frame {int(np.nanargmax(off))}, by {np.nanmax(off) * 1e3:.1f} mm"
        count = "1 frame jumps" if len(jumps) == 1 else f"{len(jumps)} frames jump"
        notes.append(("warning", f"{count} as a whole, {most}."))
    shared = look.shared
    if look.shared.changes:
        together, one = (f"{std * 1e3:.1f} mm" for std in (shared.common, shared.one))
        text = (
            f"the depth of the whole centre changes by {together} from frame to frame, a pixel beside its neighbours "
        )
        text += f"by {one}: camera or scene moved, and no number here is one of the camera"
        notes.append(("bad", f"{text}; record a still scene."))
    elif shared.told and not moves:
        # averaging frames does nothing to what is one steady change
        frames = f"nor does averaging frames, as {shared.drift_text}: record a still scene"
        over = frames if shared.steady else "averaging frames does"
        notes.append(("warning", f"{shared.text()}; averaging pixels does not remove it, {over}."))
    return notes


def _movement(look: StretchLook) -> str:
    still = look.still
    share = float(still.moving.mean())
    frames = still.disturbed
    cleaned = "it is left out of the statistics there"
    pixels = 100 * float((still.moved > 0).mean())
    lost = float(np.mean(still.moved == still.frames))
    more = f"; {100 * lost:.0f} % of the pixels have no still frame" if lost > MOVED else ""
    return (
        f"something moves in {len(frames)} of {still.frames} frames, the first {frames[0]}, over "
        f"{pixels:.0f} % of the image ({100 * share:.1f} % of all values): {cleaned}{more}."
    )
