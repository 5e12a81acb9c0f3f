"""Small recordings by makers' own libraries, without a camera."""
