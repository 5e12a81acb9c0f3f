"""The page of an explanation: claims, evidence, what cannot be told."""
