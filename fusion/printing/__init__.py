"""A scan made ready to print: closed, on its feet, with fewer triangles, and what a printer would stumble over."""
