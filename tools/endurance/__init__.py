"""What the program withstands: broken input, kills, threads, long and large recordings."""
