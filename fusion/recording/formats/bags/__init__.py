"""Bags: recorded messages of ROS 1, ROS 2 (sqlite3, MCAP), RealSense and Orbbec cameras."""
