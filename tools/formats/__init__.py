"""The judge of the readers of recordings: scenes, measures, and every command on every format."""
