"""Policies that each master one domain, and what learns from them."""
