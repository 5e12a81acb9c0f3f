"""Cameras on USB, and recordings played back as if they were cameras: sources of frames."""
