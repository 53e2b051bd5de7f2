"""What capture does wrong as a whole: it freezes, falls to zero, throws the root away, takes one thing for another."""
