"""Faults of logs that their data alone show."""
