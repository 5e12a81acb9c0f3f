"""Commands about meshes: compared with a reference, or with each other."""
