"""The laws of noise: which form, its numbers, their intervals."""
