"""Where depth jumps between neighbouring pixels, and what a pixel there measures."""
