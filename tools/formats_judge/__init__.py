"""The judge of the readers of recordings: scenes, writers by the formats' own or independent libraries, measures."""
