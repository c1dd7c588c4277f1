"""Model-agnostic meta-learning: parameters from which a gradient step or a few lead to every task's policy."""
