"""The turntable: what turns, about which axis, by which angles; poses in, poses out."""
