"""Themes of broken inputs."""
