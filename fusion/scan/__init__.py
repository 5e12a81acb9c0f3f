"""The pipeline for a turntable: a recording becomes the mesh of an object, with the evidence for it."""
