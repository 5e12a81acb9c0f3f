"""Commands that make a model: from the demo to the texture."""
