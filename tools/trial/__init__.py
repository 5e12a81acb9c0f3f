"""The trial beside its generator: runs the engine and plainer methods as processes of their own, seals, scores."""
