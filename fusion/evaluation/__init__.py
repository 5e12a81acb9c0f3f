"""What a depth camera does in front of a still scene: statistics, bias, noise, shares, steps, drift."""
