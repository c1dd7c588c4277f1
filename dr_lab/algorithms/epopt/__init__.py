"""Policies for the worst share of contexts."""
