"""What the effects' laws are made of: disparity, phasors, fields, tables, surfaces that move."""
