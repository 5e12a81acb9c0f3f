"""What stands in a room, and how it looks."""
