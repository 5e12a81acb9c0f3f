"""The image files behind a recording's frames: headers, pixels, masks."""
