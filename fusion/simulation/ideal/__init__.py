"""Perfect depth of any simulator as a sensor would have made it: what a view needs is computed from the depth."""
