"""Pages that lay one thing beside another: a mesh and its reference, repeated scans, sensors."""
