"""Statistics of one still stretch: mean, noise, shares, drift."""
