"""Boards in pictures: what a board is, and where its corners are."""
