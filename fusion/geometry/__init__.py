"""Rigid poses, cameras, depth images and triangle meshes' plain data: numpy only, no files."""
