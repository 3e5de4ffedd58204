"""Periodic orbits and what is read off them."""
