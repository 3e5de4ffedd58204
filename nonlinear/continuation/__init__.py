"""Branches of periodic orbits, their folds, and what a stepped sine finds of them."""
