"""How the motion begins: from what was told, or from all pairs of views alone."""
