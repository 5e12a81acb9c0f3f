"""Recordings drawn by generators that share no code with the program, and rules for what it makes of them."""
