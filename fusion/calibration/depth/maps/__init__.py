"""What is left per pixel, and the error over distance as one curve."""
