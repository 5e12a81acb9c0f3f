"""Units of two sensors that nobody has seen: calibration recordings and a turntable scan of each, with their truth."""
