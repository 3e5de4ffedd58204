"""From equations of motion to time simulation, periodic steady state and sweeps."""
