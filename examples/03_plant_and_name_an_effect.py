"""Hide an effect in simulated recordings, and let the program say which one it is.

python examples/03_plant_and_name_an_effect.py
"""

import tempfile
from pathlib import Path

import fusion
from fusion.sensor.effects.phase.cyclic_error import CyclicError
from fusion.sensor.effects.readout.axial_noise import AxialNoise

known = fusion.Sensor("known", "itof", (AxialNoise(c0=0.001, c2=0.0005),))
real = known.having(CyclicError(amplitude=0.003, period=0.62, phase=0.5))
SETTINGS = [(0.8, 0), (1.1, 30), (1.4, -25), (1.9, 10), (2.3, -35)]  # distance [m], tilt [deg]

with tempfile.TemporaryDirectory() as folder:
    recordings = []
    for seed, (distance, tilt) in enumerate(SETTINGS):
        path = Path(folder) / f"rec_{seed}"
        scene = fusion.built_in("patches", {"distance_m": distance, "tilt_deg": tilt, "frames": 4})
        fusion.write_simulation(path, fusion.simulate(scene, real, seed))
        recordings.append(fusion.open_recording(path))
    found = fusion.explain(recordings, known)
    verdict = fusion.verdict_of(found)

print(found)
for claim in verdict.missing:
    print(claim.effect, {name: number.value for name, number in claim.parameters.items()})
