"""A recording set right by what comes later."""
