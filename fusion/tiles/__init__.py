"""Volumes larger than memory: space is cut into tiles, which are fused one after the other into one mesh."""
