"""The real machine, as training and evaluation see it: it is driven and watched, and nothing else."""
