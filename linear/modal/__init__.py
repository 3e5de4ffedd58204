"""Natural modes: what moves, how it decays, and how modes change."""
