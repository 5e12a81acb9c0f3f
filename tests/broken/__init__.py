"""Broken inputs against the program."""
