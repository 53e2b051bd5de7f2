"""One frame as the terms want it."""
