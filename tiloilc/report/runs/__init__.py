"""A run folder as values."""
