"""What parameters do: exact derivatives, finite changes, and thousands of variants."""
