"""Passes that make an automaton smaller and keep its language."""
