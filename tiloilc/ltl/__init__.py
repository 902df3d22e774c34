"""The ltl package."""
