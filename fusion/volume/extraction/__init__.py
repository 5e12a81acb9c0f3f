"""The zero surface as a mesh: edges it crosses, triangles of each cell."""
