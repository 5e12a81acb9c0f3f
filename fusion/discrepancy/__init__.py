"""Where simulation and recording differ, and which physics is missing; the physics is in the sensor's effects."""
