"""What the object stands on: plate, level, upright."""
