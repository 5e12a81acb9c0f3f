"""Cards: devices with memory of their own, what is tried on them, and what is there."""
