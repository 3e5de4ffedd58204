"""Where a model rests."""
