"""Scene: what stood before the camera as the recording states it: its mesh, poses, table and walls."""
