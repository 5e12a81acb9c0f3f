"""Kinect v2: from the ten raw images of a frame to depth and infrared. Without transport: nobody could test one."""
