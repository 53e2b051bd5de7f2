"""Joints in one image, without memory: a forest of body parts and the pictures it learns from."""
