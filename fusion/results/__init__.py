"""What commands, pages and JSON share: each quantity is computed once, and put into words once."""
