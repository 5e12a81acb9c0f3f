"""What every pixel of a camera sees, exactly: rays, edges, shadows, light."""
