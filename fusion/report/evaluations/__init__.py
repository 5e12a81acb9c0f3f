"""Pages of the sensor bench: one unit, many units, a measured camera."""
