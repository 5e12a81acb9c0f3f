"""A mesh as a picture: what is seen from one side, and how light falls on it."""
