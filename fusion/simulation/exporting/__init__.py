"""A measured model in the parameters that other simulators understand, and what is lost on the way."""
