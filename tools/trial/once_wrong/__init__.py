"""Recordings that `fusion explain` once explained wrongly: each a row, made anew with random numbers of its own."""
