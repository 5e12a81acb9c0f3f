"""What a sensor does, found from recordings of known things: noise, valid shares, and later depth and lens."""
