"""How far a mesh stands from its reference: signed distances in both directions."""
