"""The built-in vehicles: one module per model, one TOML file per set of parameters."""
