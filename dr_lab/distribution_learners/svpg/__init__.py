"""Stein variational policy gradient: policies that climb and keep apart."""
