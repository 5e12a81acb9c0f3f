"""Pages of calibrations: camera, depth, noise."""
