"""Samples that are wrong for a while, and samples that only look so."""
