"""Rooms and a table that a hand-held camera walks around, and rules for what a program makes of them."""
