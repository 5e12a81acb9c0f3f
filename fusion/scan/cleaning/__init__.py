"""The object alone: what of a surface is not it, and where it was cut off its plate."""
