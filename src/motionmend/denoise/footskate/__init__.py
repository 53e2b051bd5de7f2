"""Foot-skate clean-up (Kovar, Schreiner and Gleicher 2002)."""
