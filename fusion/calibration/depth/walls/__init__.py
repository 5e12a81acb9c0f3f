"""What a wall or board tells: its plane, its depth, its light."""
