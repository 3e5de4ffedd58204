"""The steady state of many variants, side by side, kept as they come."""
