"""The camera's own geometry from pictures of a board, and how well it is known."""
