"""The input doctor: what is in a recording, and what looks wrong with it."""
