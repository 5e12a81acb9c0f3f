"""How far each pixel is trusted: its standard deviation, and what lies at depth edges."""
