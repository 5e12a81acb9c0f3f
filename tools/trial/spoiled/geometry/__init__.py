"""Planes and meshes that are moved, by numpy alone."""
