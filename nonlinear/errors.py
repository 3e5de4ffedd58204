"""What can go wrong with a periodic orbit."""


class NoPeriodicOrbitError(RuntimeError):
    """No periodic orbit was found: the message names the cause and what to try."""
