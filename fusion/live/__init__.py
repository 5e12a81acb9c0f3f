"""Scanning while the table turns: tracked and fused at the camera's rate, shown to whoever looks."""
