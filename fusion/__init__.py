"""fusion: metric 3D scanning with depth cameras."""

__version__ = "0.1.0"
