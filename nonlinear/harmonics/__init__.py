"""Fourier series of periodic motions, and the balance of their harmonics."""
