"""Recordings: frames loaded when needed, the native folder, other formats, and what looks wrong with them."""
