"""Pages about the sensor effects, made from the effect objects."""
