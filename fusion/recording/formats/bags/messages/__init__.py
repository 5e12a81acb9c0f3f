"""Messages as bytes and as values by the names of their fields."""
