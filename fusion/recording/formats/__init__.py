"""One file per recording format that is read."""
