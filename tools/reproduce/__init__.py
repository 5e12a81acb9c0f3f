"""Figures of papers, of README and docs, measured again."""
