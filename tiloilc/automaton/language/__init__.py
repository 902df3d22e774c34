"""Questions about the language of an automaton, answered with words."""
