"""The moments of a recording's frames, from its time stamps and its telemetry."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fusion.recording.native.telemetry_file import PLAUSIBLE
from fusion.recording.recording import Recording
from fusion.sensor.moment import Moment

Array = NDArray[np.float64]

USED = ("temperature_c", "ambient_lux", "turntable_deg")
UPTIME = 1e8  # [s] three years: larger stamps are dates, which do not tell when the sensor was switched on


@dataclass(frozen=True)
class Moments:
    """The conditions of every frame of a recording, as far as they were logged."""

    time: Array  # (n,) since the sensor was switched on [s]; years (warm) where the stamps are dates
    temperature: Array  # (n,) [degC], NaN where not known
    ambient: Array  # (n,) [lux], NaN where not known
    table_angle: Array  # (n,) as commanded [rad], NaN where not known
    warnings: tuple[str, ...] = ()  # what in the log cannot be used, one sentence each

    def __getitem__(self, index: int) -> Moment:
        return Moment(
            time=float(self.time[index]),
            temperature=float(self.temperature[index]),
            ambient=float(np.nan_to_num(self.ambient[index])),
            table_angle=float(np.nan_to_num(self.table_angle[index])),
        )


def moments_of(recording: Recording) -> Moments:
    """The moments of all frames; a column that is missing, blank or beyond all sense counts as not logged."""
    columns, warnings = {}, []
    for name in USED:
        low, high = PLAUSIBLE[name]
        values = recording.telemetry_at_frames(name)
        if values is not None and not ((values >= low) & (values <= high)).all():
            seen = f"{np.min(values):.3g} to {np.max(values):.3g}"
            warnings.append(f"{name} of the telemetry is not used: {seen} is outside {low:g} to {high:g}")
            values = None
        columns[name] = np.full(len(recording), np.nan) if values is None else np.asarray(values, float)
    stamps = np.asarray(recording.timestamps, float)
    dated = not np.isfinite(stamps).all() or bool((np.abs(stamps) > UPTIME).any())
    # a camera in use is taken to be warm; a negative stamp is before it was switched on
    time = np.full(len(stamps), UPTIME) if dated else np.maximum(stamps, 0.0)
    angle = np.deg2rad(columns["turntable_deg"])
    return Moments(time, columns["temperature_c"], columns["ambient_lux"], angle, tuple(warnings))
