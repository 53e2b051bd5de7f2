"""Spatio-temporal filter bases: the robust optimisation and what it says of a recording (section 2.2)."""
