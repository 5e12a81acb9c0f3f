"""Commands about cameras: calibrated, evaluated, described, explained."""
