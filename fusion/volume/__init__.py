"""The sparse truncated signed distance volume: integrate, raycast, extract a surface."""
