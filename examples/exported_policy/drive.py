"""A trained policy in an ordinary Gymnasium loop: python drive.py RUN"""

import sys

import gymnasium

import tiloilc
import tiloilc.tasks  # registers the environment; yours would be imported here

env = gymnasium.make("tiloilc/GridAvoid-v0", distance=7, max_episode_steps=17)
policy = tiloilc.load_policy(sys.argv[1])
observation, _ = env.reset(seed=1)
policy.reset()
done = False
while not done:
    action = policy.act(observation)  # reads the label, steps the automaton, acts
    observation, _, terminated, truncated, _ = env.step(action)
    done = terminated or truncated
policy.observe(observation)  # the last one counts, too
print(f"accepting at {policy.visits} of 17 steps{', then lost' if policy.lost else ''}")
