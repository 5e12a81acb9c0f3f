"""Pages of scans: one, several passes merged, their texture."""
