"""The learn package."""
