"""Commands about recordings: made, looked at, converted, simulated."""
