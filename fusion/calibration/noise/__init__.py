"""Noise, edges and valid shares from a flat target at many poses: poses, laws, effects, the light."""
