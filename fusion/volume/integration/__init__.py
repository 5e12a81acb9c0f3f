"""Fusing a depth image: which blocks it needs, the planes that touch its surface, the update of every voxel."""
