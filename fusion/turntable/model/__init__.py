"""Every frame against the model that all frames make together."""
