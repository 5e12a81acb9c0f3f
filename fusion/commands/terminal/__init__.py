"""What a person sees while a command runs, and what ends it from outside."""
