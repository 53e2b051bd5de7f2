"""How noisy each channel and each moment is, told from the recording."""
