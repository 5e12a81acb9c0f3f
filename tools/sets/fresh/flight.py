"""Time of flight below the level of depth: waveforms of lamp and gate, phasors, raw samples, then range.

What goes wrong has the causes that it has in a camera. The lamp shines in pulses of finite rise and a duty that is not
a half, the gate likewise: the correlation has harmonics, which three samples cannot tell from the fundamental (the
range wiggles). Each pixel and each column has a delay of its own, and it grows away from the centre of the chip; the
lamp stands beside the lens; a little light of the whole image and of the electronics falls on every pixel, so that
dark surfaces are off by more. Four places per pixel are gathered: at edges the phasors mix.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.sets.fresh.lens import Lens
from tools.sets.fresh.views import NOTHING, Scene, View

Array = NDArray[np.float64]
Light = NDArray[np.complex128]

SPEED = 299_792_458.0
HERTZ = np.array([80e6, 16e6, 120e6])
STEPS = 2 * np.pi * np.arange(3) / 3
TURN = 4 * np.pi * HERTZ / SPEED  # phase per metre of range
SHARE = HERTZ**2 / (HERTZ**2).sum()  # of each modulation in the range given out
ORDERS = np.arange(2, 9)


@dataclass(frozen=True)
class Flight:
    """A unit.

    Attributes:
        harmonics: (3, orders) complex, of the correlation, over its fundamental.
        delay: (h, w) [m] of range, of pixels, columns and the chip's radius, with the offset.
        lamp: (3,) where the lamp is [m], camera frame.
        ghost: (3,) complex [count] that is added everywhere; `veil`: share of the mean light of the image.
        counts: amplitude at 1 m, white, on the axis; `profile`: the lamp's cosine power.
        grain, dark: variance of a raw sample per count, and without light.
    """

    lens: Lens
    harmonics: Light
    delay: Array
    lamp: Array
    ghost: Light
    veil: float
    counts: float
    profile: float
    grain: float
    dark: float
    lowest: float = 85.0
    principle = "itof"
    counts_per_metre = 1000

    def gathered(self, views: list[View], rays: list[Array], ideal: bool) -> tuple[Light, Array, NDArray[np.bool_]]:
        """(3, n) light in counts of n pixels, the mean range (n,) of what they see, which they are (h, w)."""
        active = np.any([view.part != NOTHING for view in views], axis=0)
        total = np.zeros((3, int(active.sum())), complex)
        length, seen = np.zeros(total.shape[1]), np.zeros(total.shape[1])
        for view, every in zip(views, rays, strict=True):
            hit, ray = (view.part != NOTHING)[active], every[active]
            z = np.where(hit, view.z[active], 1.0)
            stretch = np.linalg.norm(ray, axis=-1)
            r = z * stretch
            way = r if ideal else (r + np.linalg.norm(z[:, None] * ray - self.lamp, axis=-1)) / 2
            back = view.reflectance[active] * view.cosine[active] * stretch**-self.profile
            total += hit * self.counts * back / r**2 / len(views) * np.exp(1j * TURN[:, None] * way)
            length, seen = length + hit * r, seen + hit
        return total, length / np.maximum(seen, 1), active

    def samples(self, light: Light, active: NDArray[np.bool_], ideal: bool) -> tuple[Array, Array]:
        """(3, 3, n) raw values without noise, and the size (3, n) of the light, which makes their shot noise."""
        if not ideal:
            light = light + self.veil * light.sum(axis=1, keepdims=True) / active.size + self.ghost[:, None]
            light = light * np.exp(1j * TURN[:, None] * self.delay[active])
        size, phase = np.abs(light), np.angle(light)[:, None] - STEPS[None, :, None]
        raw = np.cos(phase)
        for order, each in zip(ORDERS, self.harmonics.T, strict=True) if not ideal else ():
            raw = raw + np.abs(each)[:, None, None] * np.cos(order * phase + np.angle(each)[:, None, None])
        return size[:, None] * raw, size

    def frames(
        self, scene: Scene, count: int, rng: np.random.Generator, rays: list[Array], ideal: bool = False
    ) -> tuple[Array, Array]:
        """Depth (n, h, w) [m], 0 where invalid, and the amplitude (h, w) of the first; `ideal`: noise only."""
        light, near, active = self.gathered([scene.look(r) for r in rays], rays, ideal)
        raw, size = self.samples(light, active, ideal)
        stretch = np.mean([np.linalg.norm(ray[active], axis=-1) for ray in rays], axis=0)
        spread = np.sqrt(self.grain * size[:, None] + self.dark)
        out = np.zeros((count, *active.shape))
        first = np.abs(self.ghost).mean() + np.sqrt(self.dark / 2) * np.abs(rng.standard_normal(active.shape))
        for i in range(count):
            noisy = raw + spread * rng.standard_normal(raw.shape)
            seen = 2 / 3 * (noisy * np.exp(1j * STEPS)[None, :, None]).sum(axis=1)
            apart = np.angle(seen * np.exp(-1j * TURN[:, None] * near)) / TURN[:, None]
            amplitude = np.abs(seen).mean(axis=0)
            if i == 0:
                first[active] = amplitude
            out[i, active] = np.where(amplitude < self.lowest, 0.0, (near + SHARE @ apart) / stretch)
        return out, first

    def range_std(self, amplitude: Array) -> Array:
        """Standard deviation [m] of the range of one frame at amplitudes [count]."""
        one = 2 / 3 * (self.grain * amplitude + self.dark) / amplitude**2  # variance of a phase
        return np.asarray(np.sqrt((SHARE**2 / TURN**2).sum() * one))

    def sensor(self, rng: np.random.Generator) -> list[dict[str, Any]]:
        """What its owner knows of it: lamp profile, noise, threshold."""
        z = np.linspace(0.5, 2.5, 30)
        c2, c1, c0 = np.polyfit(z, self.range_std(self.counts * 0.8 / z**2), 2)
        high = float(self.range_std(np.array([1e9]))[0]) * np.sqrt(1e9)
        shot, floor = high / np.sqrt(1000), float(np.sqrt((SHARE**2 / TURN**2).sum() * 2 / 3 * self.dark)) / 1000
        off = 1 + 0.03 * float(rng.standard_normal())
        noise = {
            "c0": (c0, "m", abs(c0) / 4), "c1": (c1, "1", abs(c1) / 4), "c2": (c2, "1/m", abs(c2) / 4),
            "shot": (shot * off, "m", 0.03 * shot), "floor": (floor * off, "m", 0.03 * floor),
            "ir_reference": (1000.0, "count", 0),
        }  # fmt: skip
        return [
            stated("illumination_vignetting", exponent=(self.profile + 0.1 * rng.standard_normal(), "1", 0.2)),
            stated("mixed_pixels", fill=(1.0, "1", 0.05)),
            stated("axial_noise", **noise),
            stated("amplitude_dropout", ir_threshold=(self.lowest, "count", 5)),
            stated("depth_quantization", step=(0.001, "m", 0)),
        ]


def stated(effect: str, **values: tuple[float, str, float]) -> dict[str, Any]:
    """An entry of sensor.json: (value, unit, std) by name."""
    told = {name: {"value": float(v), "unit": unit, "std": float(std)} for name, (v, unit, std) in values.items()}
    return {"effect": effect, "parameters": told, "source": "data sheet"}


def harmonics(rng: np.random.Generator) -> Light:
    """(3, orders) of lamp and gate: pulses of some duty, a lamp that rises and falls exponentially."""
    duty, gate = rng.uniform(0.41, 0.49), rng.uniform(0.47, 0.5)
    rise = rng.uniform(0.6e-9, 1.4e-9)
    k = np.concatenate([[1], ORDERS])[None, :]
    pulses = np.sinc(k * duty) * duty * np.sinc(k * gate) * gate
    whole = pulses / (1 + 2j * np.pi * k * HERTZ[:, None] * rise)
    first = whole[:, :1] / np.abs(whole[:, :1])
    return np.asarray(whole[:, 1:] / first ** k[:, 1:] / np.abs(whole[:, :1]))


def drawn(rng: np.random.Generator, lens: Lens) -> Flight:
    """A unit with a lens."""
    v, u = np.mgrid[: lens.height, : lens.width].astype(float)
    x, y = (u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy
    delay = rng.uniform(-0.008, 0.008) + rng.uniform(-0.003, 0.003) * x + rng.uniform(-0.002, 0.002) * y
    delay = delay + 0.009 * np.clip(rng.standard_normal(), -2, 2) * (x**2 + y**2)
    delay = delay + rng.uniform(0.0003, 0.0012) * rng.standard_normal(u.shape)
    spread = float((SHARE**2 / TURN**2).sum()) * 2 / 3
    shot, floor = rng.uniform(0.0022, 0.0035, 2)
    ghost = rng.uniform(0, 12) * np.exp(2j * np.pi * rng.random(3))
    lamp = np.array([rng.choice([-1, 1]) * rng.uniform(0.02, 0.06), 0, 0])
    return Flight(
        lens, harmonics(rng), delay, lamp, ghost, rng.uniform(0, 0.006), rng.uniform(10000, 15000),
        rng.uniform(1.9, 2.3), shot**2 * 1000 / spread, floor**2 * 1e6 / spread,
    )  # fmt: skip
