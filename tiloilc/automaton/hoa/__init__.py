"""HOA v1: the text format that tools for ω-automata exchange."""
