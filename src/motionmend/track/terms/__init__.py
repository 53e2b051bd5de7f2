"""The terms of the objective, and their minimum in one frame (sections 3.4 to 3.6)."""
