"""Where a track begins: a first pose, and what is done if it was wrong."""
