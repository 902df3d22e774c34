"""The verbs that read formulas and automata."""
