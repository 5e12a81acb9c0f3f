"""Figures of scans, with a reference and without."""
