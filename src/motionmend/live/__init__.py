"""Correction while it happens: messages, the server, and the ways out to avatars and laboratories."""
