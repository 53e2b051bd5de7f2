"""Limbs, and the whole body, tried elsewhere; how well they explain a frame, and how sure they are."""
