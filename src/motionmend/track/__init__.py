"""The tracking room: one body followed through one depth and colour stream (section 3 of the dissertation)."""
