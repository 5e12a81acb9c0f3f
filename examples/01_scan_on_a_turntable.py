"""Scan an object on a turntable and measure it against a reference.

python examples/01_scan_on_a_turntable.py RECORDING OUT.ply [REFERENCE]
"""

import sys
from pathlib import Path

import numpy as np

from fusion.mesh.compare import CompareSettings, compare
from fusion.mesh.files import read_mesh, write_mesh
from fusion.recording.open import open_recording
from fusion.scan.pipeline import scan_turntable
from fusion.scan.settings import ScanSettings

if len(sys.argv) < 3:
    sys.exit(__doc__)
scan = scan_turntable(open_recording(sys.argv[1]), ScanSettings())
write_mesh(Path(sys.argv[2]), scan.mesh)
print(f"the table turned {np.rad2deg(scan.steps.mean):.2f} deg a frame; slips: {scan.steps.slips or 'none'}")
for _, sentence in scan.warnings:
    print("look at:", sentence)
if len(sys.argv) > 3:
    result = compare(scan.mesh, read_mesh(Path(sys.argv[3])), CompareSettings(scale=True))
    print(f"rms distance {result.accuracy['rms'] * 1e3:.2f} mm, scale {result.scale:.4f}")
