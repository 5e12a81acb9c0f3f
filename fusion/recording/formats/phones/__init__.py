"""Recordings that phones make: Record3D, Stray Scanner, Polycam."""
