"""Which camera took the frames, and how its depth and colour images lie to each other."""
