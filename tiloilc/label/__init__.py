"""The label package."""
