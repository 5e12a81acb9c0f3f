"""What a scan knows of its own faults, as lights."""
