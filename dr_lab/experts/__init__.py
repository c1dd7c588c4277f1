"""Where trajectories of an expert come from, which policies imitate or simulations are fitted to."""
