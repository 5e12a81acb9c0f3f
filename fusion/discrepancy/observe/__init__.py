"""What recordings show beyond the prediction: known scenes, blocks of frames, tiles."""
