"""Recordings written in the native format and in those of other programs."""
