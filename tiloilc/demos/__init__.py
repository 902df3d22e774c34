"""The demos package."""
