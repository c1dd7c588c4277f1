"""The catalogue of physical effects a model may be missing: one phenomenon a file."""
