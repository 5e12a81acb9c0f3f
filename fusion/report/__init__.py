"""Figures and the one self-contained report page."""
