"""fusion: metric 3D scanning with depth cameras."""

import os

__version__ = "0.1.0"

# Taichi prints a line to stdout while it is imported, which would spoil what commands print with --json
os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
