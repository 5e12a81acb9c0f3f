"""The back end, Taichi or Quadrants: imported, started and called, in one place."""
