"""Which episodes judge a policy, by their seeds."""

VALIDATION, EVALUATION = 1_000_000_000, 2_000_000_000
"""Where the seeds of these episodes begin; those of training are hashes of 32 bits. Policies are
chosen on validation episodes and reported on evaluation episodes."""
