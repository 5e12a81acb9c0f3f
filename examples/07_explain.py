"""
Hide an effect, and let it be named
===================================

A time-of-flight camera wiggles: its error is a wave over the distance. The model that is given knows nothing of it, and
``explain`` says from recordings of a known scene what is missing, and how large it is.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import fusion
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.axial_noise import AxialNoise

known = fusion.Sensor("known", "itof", (AxialNoise(c0=0.001, c2=0.0005),))
real = known.having(CyclicError(amplitude=0.003, period=0.62, phase=0.5))

# %%
# Patches at several distances [m] and tilts [deg]; two frames of each are enough for what is large.

camera = fusion.Camera(256, 212, fx=182.7, fy=182.7, cx=127.5, cy=105.5)
folder = Path(tempfile.mkdtemp())
recordings = []
for seed, (distance, tilt) in enumerate([(0.8, 0), (1.1, 30), (1.4, -25), (1.9, 10), (2.3, -35)]):
    scene = fusion.built_in("patches", {"distance_m": distance, "tilt_deg": tilt, "frames": 2})
    fusion.write_simulation(folder / f"rec_{seed}", fusion.simulate(replace(scene, camera=camera), real, seed))
    recordings.append(fusion.open_recording(folder / f"rec_{seed}"))

# %%
# The answer is a list of claims with what they rest on, and a model that holds them.

found = fusion.explain(recordings, known)
verdict = fusion.verdict_of(found)
for claim in verdict.missing:
    for name, number in claim.parameters.items():
        print(f"{claim.effect}.{name} = {number.value:.5f} +- {number.std:.5f} {number.unit}")
found

# %%
# What was hidden, and what was found.

distance = np.linspace(0.6, 2.6, 400)
hidden = (0.003, 0.62, 0.5)
named = [verdict.missing[0].parameters[key].value for key in ("amplitude", "period", "phase")]
for label, (amplitude, period, phase) in {"hidden": hidden, "found": named}.items():
    wave = 1e3 * amplitude * np.sin(2 * np.pi * distance / period + phase)
    plt.plot(distance, wave, "--" if label == "found" else "-", label=label)
plt.xlabel("distance [m]")
plt.ylabel("error [mm]")
plt.legend()
