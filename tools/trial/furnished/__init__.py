"""Furnished rooms with concealed effects: a generator by somebody who never saw the engine."""
