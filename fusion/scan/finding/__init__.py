"""The object and its motion: frames cut to it, the turn, the poses."""
