"""What one frame does not tell apart: front and back, left and right, one pose and another."""
