"""Phenomena a plant may hide, one a file; each law is written here on its own, not taken from the catalogue."""
