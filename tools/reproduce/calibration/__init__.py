"""Figures of calibrations, simulated and real."""
