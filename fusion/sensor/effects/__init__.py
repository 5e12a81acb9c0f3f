"""One file per sensor effect."""
