"""The steady state of a harmonic test by several methods, with one type of result."""
