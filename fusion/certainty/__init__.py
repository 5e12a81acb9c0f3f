"""How sure each vertex of a scanned surface is: its standard deviation along the normal, derived and not fitted."""
