"""The inverse of a sensor model: from what a recording holds to the depth of the true camera."""
