"""What a trained policy is worth: over grids of contexts, after fine-tuning, and on the real machine."""
