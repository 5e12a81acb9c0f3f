"""Depth correction from walls: planes, candidate laws, held-out errors, one curve with its interval."""
