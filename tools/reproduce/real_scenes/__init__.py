"""Real recordings as recordings of known scenes, so that `fusion explain` can be asked about them."""
