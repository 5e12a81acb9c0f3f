"""Recordings spoiled as users spoil them, and what `fusion explain` may say then; nothing of the program is used."""
