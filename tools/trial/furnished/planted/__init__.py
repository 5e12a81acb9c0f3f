"""Effects that may be concealed, a function each: it draws how large the effect is and tells what it is."""
