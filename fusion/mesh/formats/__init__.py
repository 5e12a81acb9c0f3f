"""One file per mesh format that is read: bytes in, a mesh out; ValueError where not all is there that is promised."""
