"""Simulated recordings: scenes and a ray caster of its own, so truth never comes from the code under test."""
