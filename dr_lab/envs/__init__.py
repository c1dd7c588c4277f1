"""Batched TorchRL environments on the simulator, and their tasks."""
