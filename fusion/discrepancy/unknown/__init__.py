"""What no entry of the catalogue explains."""
