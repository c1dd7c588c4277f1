"""The next experiment: commands that may be played and that would tell most."""
