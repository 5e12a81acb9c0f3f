"""Depth edges: what is recorded across them, where they may stand, and which effect makes that of them."""
