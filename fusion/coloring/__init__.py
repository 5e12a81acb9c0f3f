"""The colour of a finished mesh, from the recorded colour images and the places they were taken from."""
