"""Periodic orbits in pieces that end where a force bends, and their Floquet multipliers."""
