"""A reader of the files by their contract alone, and what they must hold; shares no code with what makes them."""
