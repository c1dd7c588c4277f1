"""What the training verbs share: the loop, checkpoints, episodes of a policy, the distribution over time."""
