"""Which seeds agents may have: known to the models of files, and to options, which load none."""

MOST_AGENTS = 1000
"""That are trained together."""

LAST_SEED = 2**31 - 1
