"""The pipeline for a moving camera: a recording becomes the mesh of an object or a room, with the evidence for it."""
