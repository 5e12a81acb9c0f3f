"""A mesh laid on its reference: guesses, robust ICP, scale and how well it is known."""
