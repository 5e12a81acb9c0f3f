"""The sensor as one model: effects, their sum, presets."""
