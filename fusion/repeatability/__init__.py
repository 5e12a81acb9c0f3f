"""Several scans of one object: laid on each other, none as the reference; how far they spread, what they agree on."""
