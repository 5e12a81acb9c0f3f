"""Several passes of one object become one: how they lie to each other, refined together, fused once."""
