"""What may be concealed: laws of the light, the electronics and the matching."""
