"""From a formula to the states of its automaton: unfolding, breakpoints, guesses."""
