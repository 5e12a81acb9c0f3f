"""Files that hold messages, whatever is in them."""
