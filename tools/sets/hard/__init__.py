"""The hard set: scans by hand and before walls, of printed round and square things, and recordings that are none."""
