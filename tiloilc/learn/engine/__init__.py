"""What learning is done with: stacked networks, SAC, replay, and what they run on."""
