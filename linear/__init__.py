"""From equations of motion to state space, modes, frequency response and sensitivity."""
