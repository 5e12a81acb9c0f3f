"""Seeing the volume: where rays have to look, which of them are followed and how, what is where they end."""
