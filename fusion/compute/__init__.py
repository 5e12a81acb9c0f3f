"""Taichi: imported, started and called, in one place."""
