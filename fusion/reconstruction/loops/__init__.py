"""What was seen twice: key frames, which of them show the same, and the poses that suit all of it."""
