"""The compiled right-hand side, and its integration in time."""
