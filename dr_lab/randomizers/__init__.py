"""Distributions p(z) of the context from which training draws the physics of each episode."""
