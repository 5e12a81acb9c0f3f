"""Triangle meshes: files, clean-up, distances, comparison with a reference."""
