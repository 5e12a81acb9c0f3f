"""Files as they come from outside: regular ones only, of a bounded size, inside their folder."""
