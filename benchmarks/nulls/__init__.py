"""Simulated machines that lack no effect of the catalogue, and what the diagnosis says of them."""
