"""One finding in a channel beside the mean."""

from dataclasses import dataclass, replace

from fusion.discrepancy.unknown.table import joined
from fusion.sensor.effect import Effect
from fusion.sensor.effects.readout.tabulated import Tabulated
from fusion.sensor.sensor import Sensor


@dataclass(frozen=True)
class ChannelStep:
    """An effect that explains what a channel shows, or a law that none explains."""

    channel: str  # "noise", "dropout", "edges", "amplitude", or "bias" of what only the stored values show
    effect: Effect | None  # as it is in the better model; None where no effect of the catalogue explains it
    std: dict[str, float]  # of its fitted parameters
    corrected: bool  # the given model held it, with values that are established to be wrong
    gain: float  # drop of the chi2 of the channel
    share: float  # of that chi2
    probability: float  # that chance alone does this, over all names
    alike: tuple[str, ...] = ()  # names that this data cannot tell from it
    variables: tuple[str, ...] = ()  # what it depends on
    text: str = ""  # one sentence for a person
    established: bool = True  # it also shows in recordings and in frames that took no part in the fit
    added: Tabulated | None = None  # the table of missing values that goes into the model in place of the effect
    form: str = ""  # the law in words, where it is a table
    posterior: float | None = None  # probability that it or one of its look-alikes is there, where it was asked

    def added_to(self, sensor: Sensor) -> Sensor:
        """The sensor with what was found."""
        if self.added is not None:
            before = sensor.sources.get("tabulated", "")
            told = f"{before}; " * bool(before) + f"explained: missing values, {self.form}"
            own = sensor.effect("tabulated")
            sensor = sensor.having(joined(own, self.added) if isinstance(own, Tabulated) else self.added)
            return replace(sensor, sources={**sensor.sources, "tabulated": told})
        return sensor if self.effect is None else sensor.having(self.effect)
