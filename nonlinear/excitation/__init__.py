"""What moves the inputs: sines, chirps, steps, measured signals."""
