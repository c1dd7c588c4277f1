"""The mean of policies that each master one context."""
