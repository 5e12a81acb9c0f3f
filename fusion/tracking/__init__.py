"""Tracking: points and normals in, poses out; knows no volume."""
