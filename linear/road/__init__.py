"""Random roads, and what they do to a vehicle and its passengers."""
