"""Rooms and what stands in them, as meshes: metres, z up."""
