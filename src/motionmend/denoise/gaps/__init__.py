"""What is put where nothing was measured, and how sure it is."""
