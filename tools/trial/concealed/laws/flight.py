"""Time of flight below the level of depth: phasors of three modulations, three raw samples each, then range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.trial.concealed.laws.law import Law, lottery, memory_of, noisier
from tools.trial.concealed.shot import Place, Shot

Array = NDArray[np.float64]

LIGHT = 299_792_458.0
MODULATIONS = np.array([80e6, 16e6, 120e6])
STEPS = 2 * np.pi * np.arange(3) / 3
PER_METRE = 4 * np.pi * MODULATIONS / LIGHT  # phase
WEIGHTS = MODULATIONS**2 / (MODULATIONS**2).sum()  # of the three ranges in the one that is given out


@dataclass(frozen=True)
class Flight:
    """Light and electronics. `shot, floor` [m] at `reference` counts; `ir` counts at 1 m, white, on the axis."""

    ir: float = 12500.0
    lamp: float = 2.1
    shot: float = 0.003
    floor: float = 0.003
    reference: float = 1000.0
    dark: float = 85.0
    bright: float = 65000.0
    simulated: bool = True

    def phasors(self, shot: Shot, laws: Sequence[Law], frame: int) -> NDArray[np.complex128]:
        """(3, h, w) light as it comes from the lens, in counts."""
        if self not in shot.kept:
            shot.kept[self] = self._direct(shot)
        total = shot.kept[self]
        place = Place(shot, frame, np.abs(total[0]))
        for law in laws:
            if law.stage == "light":
                total = total + law.share(place) * law.acts(place, total, MODULATIONS)
        delay = np.zeros(shot.hits.z.shape)
        for law in laws:
            if law.stage == "delay":
                delay += law.share(place) * np.nan_to_num(law.acts(place))
        return total * np.exp(1j * PER_METRE[:, None, None] * delay)

    def _direct(self, shot: Shot) -> NDArray[np.complex128]:
        """(3, h, w) light that went straight to a surface and back, gathered over the area of each pixel."""
        total = np.zeros((3, *shot.hits.z.shape), complex)
        for hits in shot.sub:
            r = np.nan_to_num(hits.z, nan=1.0) * shot.stretch
            counts = shot.lamp * self.ir * hits.reflectance * hits.cosine * shot.stretch**-self.lamp / r**2
            total += 0.25 * counts * np.exp(1j * PER_METRE[:, None, None] * r)
        return total

    def samples(self, light: NDArray[np.complex128], place: Place, laws: Sequence[Law]) -> Array:
        """(3 modulations, 3 steps, h, w) raw correlation values without noise."""
        size, phase = np.abs(light), np.angle(light)
        raw = size[:, None] * np.cos(phase[:, None] - STEPS[None, :, None, None])
        for law in laws:
            if law.stage == "harmonic":
                for order, height, shifts in law.acts(place):
                    angle = order * (phase[:, None] - STEPS[None, :, None, None]) + shifts[:, None, None, None]
                    raw = raw + law.share(place) * height * size[:, None] * np.cos(angle)
        return np.asarray(raw)

    def ranges(self, raw: Array, near: Array) -> tuple[Array, Array]:
        """Range (h, w) [m] and amplitude (h, w) [count] of raw samples; the right period is the one by `near` [m]."""
        seen = 2 / 3 * (raw * np.exp(1j * STEPS)[None, :, None, None]).sum(axis=1)
        apart = np.angle(seen * np.exp(-1j * PER_METRE[:, None, None] * near)) / PER_METRE[:, None, None]
        return near + np.tensordot(WEIGHTS, apart, 1), np.asarray(np.abs(seen).mean(axis=0))

    def spread(self) -> tuple[float, float]:
        """Variance of a raw sample per count, and without light, that make `shot` and `floor` of the range."""
        gain = float((WEIGHTS**2 / PER_METRE**2).sum()) * 2 / 3
        return self.shot**2 * self.reference / gain, self.floor**2 * self.reference**2 / gain

    def clean(self, shot: Shot, laws: Sequence[Law], frame: int = 0) -> Array:
        """(h, w) depth without noise."""
        place = Place(shot, frame, np.ones(shot.hits.z.shape))
        light = self.phasors(shot, laws, frame)
        r, _ = self.ranges(self.samples(light, place, laws), np.nan_to_num(shot.hits.z) * shot.stretch)
        return np.where(shot.hits.panel >= 0, r / shot.stretch, np.nan)

    def sigma(self, shot: Shot) -> Array:
        """(h, w) standard deviation [m] of the depth of one frame."""
        q = self.reference / np.maximum(np.abs(self.phasors(shot, (), 0)[0]), 1e-3)
        return np.asarray(np.sqrt(self.shot**2 * q + self.floor**2 * q**2) / shot.stretch)

    def limits(self, laws: Sequence[Law]) -> tuple[float, float]:
        """Amplitudes [count] below and above which there is no value."""
        low = max([self.dark, *(law.size * law.acts(None) for law in laws if law.stage == "dark")])
        return low, min([self.bright, *(law.size * law.acts(None) for law in laws if law.stage == "bright")])

    def record(self, shot: Shot, laws: Sequence[Law], rng: np.random.Generator) -> tuple[Array, Array]:
        """Depth (n, h, w) [m], 0 where invalid, and amplitude (h, w) of the first frame."""
        near = np.nan_to_num(shot.hits.z) * shot.stretch
        frames: list[Array] = []
        first, raw = None, None
        place = Place(shot, 0, np.ones(near.shape))
        per_count, dark = self.spread()
        memory = memory_of(laws)
        lowest, highest = self.limits(laws)
        for i in range(len(shot.times)):
            if raw is None or shot.long:
                place = Place(shot, i, np.ones(near.shape))
                light = self.phasors(shot, laws, i)
                raw = self.samples(light, place, laws)
                std = np.sqrt(per_count * np.abs(light)[:, None] + dark) * noisier(laws, place)
            r, amplitude = self.ranges(raw + std * rng.standard_normal(raw.shape), near)
            first = amplitude if first is None else first
            z = r / shot.stretch
            if memory and frames:
                z = (1 - memory) * z + memory * np.where(frames[-1] > 0, frames[-1], z)
            lost = (amplitude < lowest) | (amplitude > highest) | (shot.hits.panel < 0) | lottery(laws, place, rng)
            frames.append(np.where(lost, 0.0, z))
        assert first is not None
        return np.array(frames), first
