"""Recordings and channels: a frame that goes with the body, angles and markers in it, what a model knows of them."""
