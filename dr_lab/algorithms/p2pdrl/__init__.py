"""Peer-to-peer distillation: policies that learn side by side and keep near each other."""
