"""What a correction does to a recording, and what it leaves: for settings, reports and the console."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fusion.sensor.correction.correction import camera_effects, true_camera, view_of
from fusion.sensor.effect import Effect
from fusion.sensor.laws.moving import CameraEffect
from fusion.sensor.parameter import parameters
from fusion.sensor.sensor import Sensor
from fusion.sensor.view import View
from fusion.sensor.weights.rating import sigma_of

NOTHING = 1e-6  # [m] what `correct` promises
IR, HOT = 1000.0, 60.0  # stand-ins for an amplitude [count] and a temperature [degC] that are not known


@dataclass(frozen=True)
class CorrectionFigures:
    """A correction in short: one line, effect to size [m], errors of the camera taken out, what is left."""

    text: str
    undone_m: dict[str, float]
    true_camera: tuple[str, ...]
    left: tuple[str, ...]


@dataclass(frozen=True)
class CorrectionSummary:
    """The correction of a recording in numbers and words."""

    corrected: dict[str, float]  # effect to the median size of what was taken back in a frame that was looked at [m]
    camera: tuple[str, ...]  # names of the errors of the camera that the true camera takes out
    left: tuple[str, ...]  # what is not corrected, one sentence each with the reason
    doubtful: tuple[str, ...]  # effects that are corrected, but are known no better than the noise, one sentence each
    guessed: float = 0.0  # [m] size of what was taken back for a brightness that was guessed

    @property
    def line(self) -> str:
        """One line for a person."""
        sizes = [f"{name} {1e3 * size:.2f} mm" for name, size in self.corrected.items()]
        return ", ".join([*sizes, *(f"{name} by the true camera" for name in self.camera)]) or "nothing to correct"

    @property
    def notes(self) -> list[tuple[str, str]]:
        """(severity, sentence) as reports take them."""
        done = [("ok", f"depth corrected: {self.line}")] if self.corrected or self.camera else []
        return done + [("warning", text) for text in (*self.left, *self.doubtful)]

    def figures(self) -> CorrectionFigures:
        """As `settings.json` holds it."""
        return CorrectionFigures(self.line, self.corrected, self.camera, (*self.left, *self.doubtful))


def tell(sensor: Sensor, view: View) -> CorrectionSummary:
    """What the correction of this measured view (with depth, and what is known beside it) does and leaves."""
    assert view.depth is not None
    measured = np.asarray(view.depth, np.float32)
    full = view_of(sensor, measured, view.camera, view.ir, view.moment)
    depth = sensor.correct(measured, full)
    true = true_camera(sensor, view.camera)
    noise = _median(sigma_of(sensor, View(true, depth, ir=view.ir, moment=view.moment)))
    by_name_only = [text for text in sensor.left_out if ": not corrected (" not in text]
    corrected, left, doubtful, dark = {}, by_name_only, [], 0.0
    for effect in sensor.effects:
        # the true camera corrects those of the camera
        why = sensor.usual(effect) if isinstance(effect, CameraEffect) else sensor.why_not_corrected(effect)
        if why:
            left.append(f"{effect.name}: not corrected ({why})")
        if why or not effect.changes("bias") or isinstance(effect, CameraEffect):
            continue
        left += [f"{effect.name}: not corrected, the recording has no {what}" for what in _lacking(effect, full)]
        size = _size(effect, depth, full)
        if size > NOTHING:
            corrected[effect.name] = size
            if view.ir is None and full.ir is not None and "amplitude" in effect.variables:
                guessed = "corrected as for surfaces that reflect half of the light, as the recording has no IR"
                doubtful.append(f"{effect.name}: {guessed}")
                dark = max(dark, size)
        # the deviations of numbers that were fitted together say little one by one
        if effect.name not in sensor.fitted and (std := _std(sensor, effect, depth, full)) > noise:
            doubtful.append(
                f"{effect.name}: corrected, but known to {1e3 * std:.1f} mm only at {_median(depth):.2f} m, "
                f"worse than the noise of {1e3 * noise:.1f} mm"
            )
    moved = tuple(e.name for e in camera_effects(sensor) if e.true_camera(view.camera) != view.camera)
    return CorrectionSummary(corrected, moved, tuple(left), tuple(doubtful), dark)


def _size(effect: Effect, depth: np.ndarray, view: View) -> float:
    with np.errstate(all="ignore"):
        change = np.abs(np.broadcast_to(effect.bias(depth, view), depth.shape))
    return _median(np.where(np.isfinite(depth), change, np.nan))


def _median(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else 0.0


def _lacking(effect: Effect, view: View) -> list[str]:
    """What is not known of a view, and would change what the effect does."""
    stand_ins = {}
    if view.ir is None and view.depth is not None:
        bright = replace(view, ir=np.full(view.depth.shape, IR, np.float32))
        stand_ins["IR"] = replace(bright, reflectance=np.full(view.depth.shape, 0.5, np.float32))
    if not np.isfinite(view.moment.temperature):
        stand_ins["temperature"] = replace(view, moment=replace(view.moment, temperature=HOT))
    return [what for what, other in stand_ins.items() if _differ(effect, view, other)]


def _differ(effect: Effect, view: View, other: View) -> bool:
    assert view.depth is not None
    with np.errstate(all="ignore"):
        change = np.abs(effect.bias(view.depth, other) - effect.bias(view.depth, view))
    return bool(np.nanmax(np.nan_to_num(change), initial=0.0) > NOTHING)


def _std(sensor: Sensor, effect: Effect, depth: np.ndarray, view: View) -> float:
    """Median uncertainty [m] of what is corrected, from the standard deviations of the effect's parameters."""
    variance = np.zeros(depth.shape)
    with np.errstate(all="ignore"):
        own = effect.bias(depth, view)
        for name in parameters(effect):
            std = np.asarray(sensor.std.get((effect.name, name), 0.0))
            value = np.asarray(getattr(effect, name))
            if not np.any(std) or not np.any(value) or std.shape not in ((), value.shape):
                continue
            # each entry of a list is known by itself
            for k in range(value.size if std.ndim else 1):
                step = np.zeros(value.shape) if std.ndim else np.broadcast_to(std, value.shape)
                if std.ndim:
                    step.flat[k] = std.flat[k]
                moved = value + step
                values: dict[str, Any] = {name: moved if moved.ndim else float(moved)}
                other = replace(effect, **values)
                variance = variance + (other.bias(depth, view) - own) ** 2
    return float(np.sqrt(_median(np.where(np.isfinite(depth), variance, np.nan))))
