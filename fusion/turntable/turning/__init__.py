"""What turns, and what stands still behind it."""
