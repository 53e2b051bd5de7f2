"""The adaptive repair: rounds of library, search for outliers, smoothing and noise, in blocks, of a whole recording."""
