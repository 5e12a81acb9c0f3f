"""What the amplitude images tell of the light."""
