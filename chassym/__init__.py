"""From a vehicle file to symbolic equations of motion, state space and nonlinear steady state."""
