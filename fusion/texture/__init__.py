"""A picture laid on a finished mesh: the surface made flat, and its colours from the recorded images."""
