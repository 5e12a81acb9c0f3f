"""The camera that explains the corners best, and what does not fit it."""
