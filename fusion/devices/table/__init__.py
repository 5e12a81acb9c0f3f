"""Turntables that a program turns: step, settle, grab, step."""
