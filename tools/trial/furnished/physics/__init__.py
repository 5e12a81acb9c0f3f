"""What cameras would record: rays, raw samples, disparities; physics of its own, without the package's formulas."""
