"""The candidate laws, and which of them left-out walls believe."""
