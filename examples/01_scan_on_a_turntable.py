"""Scan an object on a turntable and measure it against a reference.

python examples/01_scan_on_a_turntable.py RECORDING OUT.ply [REFERENCE]
"""

import sys

import numpy as np

import fusion

if len(sys.argv) < 3:
    sys.exit(__doc__)
scan = fusion.scan_turntable(fusion.open_recording(sys.argv[1]))
fusion.write_mesh(sys.argv[2], scan.mesh)
print(scan)
print(f"the table turned {np.rad2deg(scan.steps.mean):.2f} deg a frame; slips: {scan.steps.slips or 'none'}")
print("\n".join(scan.judgement.lines()))
if len(sys.argv) > 3:
    print(fusion.compare(scan.mesh, fusion.read_mesh(sys.argv[3]), fusion.CompareSettings(scale=True)))
