"""How long and how wide this person is."""
