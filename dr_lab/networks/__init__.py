"""Actors and critics, and the normaliser that belongs to them."""
