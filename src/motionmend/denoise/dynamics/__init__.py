"""Learned dynamics: how poses follow each other, as a Kalman filter and in their steady state."""
