"""Single scans that something spoils, or that are hard, and what is said of them."""
