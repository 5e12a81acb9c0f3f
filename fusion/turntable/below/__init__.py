"""What is printed on the plate or sheet below the object, and turns with it: its marks tell the turns by themselves."""
