"""A training run: collecting and learning, checkpoints, events, and the job they belong to."""
