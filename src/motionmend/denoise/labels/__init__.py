"""Swapped labels: found by continuity and distances, given back and told."""
