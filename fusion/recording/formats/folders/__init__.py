"""Folders of images that other programs and people make."""
