"""Two turntable passes of one object that was turned over between them, and their judge."""
