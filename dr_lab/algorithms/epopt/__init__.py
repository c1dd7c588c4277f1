"""Policies for the worst contexts."""
