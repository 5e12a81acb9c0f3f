"""Results appear whole or not at all, and replace nothing but an earlier result of their own."""
