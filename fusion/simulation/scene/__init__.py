"""What a simulated recording is made from: surfaces, boards, the camera's course, the table."""
