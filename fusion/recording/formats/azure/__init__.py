"""Azure Kinect's and Orbbec Femto's recordings."""
