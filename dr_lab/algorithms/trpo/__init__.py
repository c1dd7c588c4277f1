"""Trust-region policy optimisation, and the steps by which a policy gradient moves parameters."""
