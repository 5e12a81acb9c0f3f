"""The channels beside the mean: what repeated frames and missing values show beyond the model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fusion.discrepancy.channels.channel_step import ChannelStep
from fusion.discrepancy.channels.dropout import dropout_steps
from fusion.discrepancy.channels.lattice import lattice_steps
from fusion.discrepancy.channels.noise import noise_steps
from fusion.discrepancy.edges.steps import edge_steps
from fusion.discrepancy.light.steps import amplitude_steps
from fusion.discrepancy.observe.frame_block import FrameBlock
from fusion.discrepancy.observe.observations import Observations
from fusion.sensor.sensor import Sensor


@dataclass(frozen=True)
class ChannelFindings:
    """What was found."""

    sensor: Sensor  # the model with all of it
    steps: tuple[ChannelStep, ...]  # one per finding

    def of(self, channel: str) -> tuple[ChannelStep, ...]:
        """The findings of one channel."""
        return tuple(step for step in self.steps if step.channel == channel)


def channels_of(observations: Observations, blocks: Sequence[FrameBlock]) -> ChannelFindings:
    """What the channels beside the mean show of observations whose mean is explained.

    Args:
        blocks: with the frames that take no part in any fit.
    """
    held = [block.held for block in blocks if block.held is not None]
    stepped, lattice = lattice_steps(observations)
    sensor, noise = noise_steps(observations.under(stepped) if lattice else observations, held)
    sensor, edges = edge_steps(replace(observations, sensor=sensor))
    # what adds noise may take values away too: the missing ones are asked about under the better noise
    better, dropout = dropout_steps(replace(observations, sensor=sensor))
    # what changes nothing but the light changes nothing that the others ask
    better, light = amplitude_steps(replace(observations, sensor=better))
    return ChannelFindings(better, (*lattice, *noise, *edges, *dropout, *light))
