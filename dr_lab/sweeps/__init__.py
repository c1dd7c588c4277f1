"""Sweeps that finish: what a sweep's folder holds, whatever engine runs its jobs and however often it is killed."""
