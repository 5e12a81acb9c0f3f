"""What is in the images besides paint: the exposure of each, the light before the camera; how far each is trusted."""
