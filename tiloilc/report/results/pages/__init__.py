"""The pages of `docs/results/`, each a function of the book of rows."""
