"""The automaton package."""
