"""How the distribution of the context is learnt beside the policy."""
