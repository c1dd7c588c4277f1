"""Faults of logs that are told before anything is fitted."""
