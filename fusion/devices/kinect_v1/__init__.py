"""Kinect for Xbox 360 and its siblings (1414, 1473, 1517): found, commanded and streamed over USB, by own code.

What the device understands and sends is restated from public sources (OpenKinect/libfreenect's source and its removed
protocol page, PrimeSense's host protocol headers); no code is theirs.
"""
