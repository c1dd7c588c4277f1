"""ADR+: particles that seek the contexts of an expert's trajectories, and stay near those of a finished run."""
